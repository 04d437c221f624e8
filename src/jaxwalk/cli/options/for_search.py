"""Options of the command that searches for failures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from jaxwalk.cli.options.declare import Flag, ShieldName, Suite, World, option

SearchMethod = Literal["map-elites", "cross-entropy", "evolution", "random", "splitting"]


@dataclass(frozen=True)
class Search:
    """Find different failures of a driver: scenarios in which its moving car touches somebody. One page.

    All chance of a scenario is a point of a cube. A search looks for points that fail, keeps the most plausible failure
    of each kind (who was touched, how fast, how late they became visible, from which side), says whether a careful
    human or the oracle would have avoided it, and how few people still fail. Run it again to continue after an
    interruption, or with more --simulations. The method splitting estimates instead how rare failures are.

    For example: jaxwalk search town --suite town --simulations 8192 --out runs/search
    """

    drivers: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="DRIVER")] = ()
    """As in `jaxwalk evaluate`: a rule, a trained policy that comes with jaxwalk, a run folder, a policy file or your
    own driver."""
    pedestrians: Annotated[str, option("always-go", "P")] = "always-go"
    """As in `jaxwalk evaluate`."""
    shield: Annotated[ShieldName | None, option("none", "SHIELD")] = None
    """Put a shield around the driver, which corrects actions that aren't safe by its rule (docs: shields)."""
    method: Annotated[SearchMethod, option("map-elites", "METHOD")] = "map-elites"
    """map-elites varies the best scenario of each kind, for many kinds of failure; cross-entropy and evolution (needs
    pip install "jaxwalk[search]") move towards one kind; random draws scenarios as an evaluation does, for comparison;
    splitting: the rate of rare failures, without bias."""
    simulations: Annotated[int, option("4096", "N")] = 4096
    """Scenarios to play, 512 in a generation; splitting takes as many as its levels need."""
    minimise: Annotated[int, option("12", "N")] = 12
    """Explain the N worst failures: as few people, and as ordinary draws, as still fail."""
    particles: Annotated[int, option("256", "N")] = 256
    """For splitting: scenarios that step from level to level at a time."""
    repeats: Annotated[int, option("10", "N")] = 10
    """For splitting: estimates, whose mean is the rate and whose spread gives the interval."""
    seed: Annotated[int, option("0", "N")] = 0
    """Seed of the search."""
    map: Annotated[tuple[str, ...], option("the run folders', else paper", "MAP [MAP ...]")] = ()
    """Bundled maps, map files, or generated streets: test:20, the first 20 of a split, or test-2000000003, the one of a
    number (docs: streets)."""
    world: Annotated[World | None, option("the run folders', else the map's", "WORLD")] = None
    """What a collision is. paper: the centres closer than 1.5 m; paper-footprint: a body touches the car, which is
    usual on other maps than paper; campus: that too, a slow car, and people at a measured pace
    (docs: real-recordings); town: as paper-footprint, and a car for towns (50 km/h, harder brakes, slower in bends);
    blind-corner and arterial: that too, and people are hidden, and many run (docs: perception)."""
    suite: Annotated[Suite | None, option("none", "SUITE")] = None
    """Instead of --map, --world and --people: streets, car and crowd under one name (docs: suites)."""
    people: Annotated[int | None, option("the run folders', else 12", "N")] = None
    """Pedestrians in an episode."""
    jaywalk_multiplier: Annotated[float | None, option("the world's", "X")] = None
    """P(jaywalk | decision) = jaywalking tendency x this: 1 where people are hidden, else 0.25."""
    out: Annotated[Path, option("runs/search", "DIR")] = Path("runs/search")
    """Folder for search.html, search.json, failures.csv and scenarios.safetensors; of splitting, for rate.json."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""
    driver_seconds: Annotated[float, option("10", "S")] = 10.0
    """Time limit of a driver that is not JAX for one step of its batch."""
