"""The options of the command that plays scenarios as they happen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from jaxwalk.cli.options.declare import Flag, World, option


@dataclass(frozen=True)
class Live:
    """Play scenarios as they happen, in a browser: choose street, people and driver, turn dials, or drive yourself.

    Starts a small server that only this machine's own page can call (docs: live), until Ctrl-C. Needs
    pip install "jaxwalk[live]".

    For example: jaxwalk live --driver my_driver.py:MyDriver --map my-street.toml --open
    """

    driver: Annotated[tuple[str, ...], option("co-trained", "D [D ...]")] = ()
    """Drivers to choose among, beside the rules and trained policies that come with jaxwalk: run folders, policy files
    or your own, as in `jaxwalk evaluate`; the first one drives first."""
    pedestrians: Annotated[tuple[str, ...], option("learned", "P [P ...]")] = ()
    """People to choose among, beside those that come with jaxwalk; the first ones come first."""
    map: Annotated[tuple[str, ...], option("paper", "MAP [MAP ...]")] = ()
    """Streets to choose among, beside paper and some generated ones: map files, test:20, test-2000000003; the first one
    is played first."""
    world: Annotated[World | None, option("the map's", "WORLD")] = None
    """The world of the first street (docs: perception); the page can choose another one."""
    people: Annotated[int | None, option("12", "N")] = None
    """Pedestrians in an episode; the page can choose more or fewer."""
    seed: Annotated[int, option("0", "N")] = 0
    """Which set of scenarios comes first."""
    scenarios: Annotated[Path | None, option("none", "FILE")] = None
    """Instead of drawing scenarios: those of a file that the page saved, or of the folder of a `jaxwalk search`, with
    their street, world and people."""
    out: Annotated[Path, option("runs/live", "DIR")] = Path("runs/live")
    """Folder for the scenarios that the page saves."""
    port: Annotated[int, option("8642", "N")] = 8642
    """Where the server listens on the loopback address; 0: any free port."""
    open: Flag = False
    """Also open the page in the browser."""
    minutes: Annotated[float | None, option("until Ctrl-C", "MIN")] = None
    """End the server after this time."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""
    driver_seconds: Annotated[float, option("10", "S")] = 10.0
    """Time limit of a driver that is not JAX for one step."""
