"""Options of the commands that write trajectories and scenarios for other tools, or measure those of others."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from jaxwalk.cli.options.declare import Flag, World, option


@dataclass(frozen=True)
class Tracks:
    """Write episodes as one table of trajectories: a row for each road user and moment.

    For example: jaxwalk tracks --driver route-follower --episodes 1000 --out tracks.parquet
    """

    driver: Annotated[str, option("needed", "D")] = ""
    """As in `jaxwalk evaluate`: a rule, a trained policy that comes with jaxwalk, a run folder or a policy file."""
    pedestrians: Annotated[str, option("always-go", "P")] = "always-go"
    """always-go, learned, a run folder or a policy file."""
    episodes: Annotated[int, option("1", "N")] = 1
    """Scenarios 0 to N - 1 of the seed, as `jaxwalk evaluate` plays them."""
    seed: Annotated[int, option("0", "N")] = 0
    """Which set of scenarios."""
    map: Annotated[str, option("the run folder's, else paper", "MAP")] = ""
    """A bundled map, a map file or a generated street, such as test-2000000003 (docs: streets)."""
    world: Annotated[World | None, option("the run folders', else the map's", "WORLD")] = None
    """What a collision is. paper: the centres closer than 1.5 m; paper-footprint: a body touches the car, which is
    usual on other maps than paper; campus: that too, a slow car, and people at a measured pace
    (docs: real-recordings); town: as paper-footprint, and a car for towns (50 km/h, harder brakes, slower in bends);
    blind-corner and arterial: that too, and people are hidden, and many run (docs: perception).
    Both kinds of contact are always counted."""
    people: Annotated[int | None, option("the run folders', else 12", "N")] = None
    """Pedestrians in an episode."""
    jaywalk_multiplier: Annotated[float | None, option("the world's", "X")] = None
    """P(jaywalk | decision) = jaywalking tendency x this: 1 where people are hidden, else 0.25."""
    out: Annotated[Path, option("tracks.parquet", "FILE")] = Path("tracks.parquet")
    """FILE.parquet; an existing file is replaced. Needs pip install "jaxwalk[data]"."""


@dataclass(frozen=True)
class Measure:
    """Compute the metrics of anybody's trajectories: surrogate safety, speed differential and whatever else they allow.

    For example: jaxwalk measure 07_tracks.csv --areas crossing.geojson
    """

    files: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="FILE [FILE ...]")] = ()
    """Tables as `jaxwalk tracks` writes them, XX_tracks.csv of inD, or NAME_traj_ped_filtered.csv of DUT or CITR."""
    areas: Annotated[Path | None, option("the table's own", "FILE")] = None
    """GeoJSON of roadway and crosswalks in the trajectories' metres; without, crossings can't be told apart."""
    frame_rate: Annotated[float | None, option("the file's", "HZ")] = None
    """Frames per second, which DUT (23.976) and CITR (29.97) do not say."""
    json: Flag = False
    """Print one JSON document instead of tables."""


@dataclass(frozen=True)
class Scenario:
    """Write one episode for other simulators: OpenSCENARIO XML with OpenDRIVE, and CommonRoad XML.

    For example: jaxwalk scenario --driver co-trained --pedestrians learned --scenario 3 --out scenario-3

    Or crash tests: jaxwalk scenario --tests euro-ncap-style --out tests
    """

    driver: Annotated[str, option("needed", "D")] = ""
    """As in `jaxwalk evaluate`: a rule, a trained policy that comes with jaxwalk, a run folder or a policy file."""
    pedestrians: Annotated[str, option("always-go", "P")] = "always-go"
    """always-go, learned, a run folder or a policy file."""
    scenario: Annotated[int, option("0", "N")] = 0
    """Number of the scenario: a row of an evaluation with the same seed."""
    seed: Annotated[int, option("0", "N")] = 0
    """Which set of scenarios."""
    scenarios: Annotated[Path | None, option("none", "FILE")] = None
    """Instead of drawing scenarios: those of a file or of a folder of `jaxwalk search` (docs: failure-search)."""
    map: Annotated[tuple[str, ...], option("the run folders', else paper", "MAP [MAP ...]")] = ()
    """Bundled maps, map files, or generated streets: test:20, the first 20 of a split, or test-2000000003, the one of a
    number (docs: streets)."""
    world: Annotated[World | None, option("the run folders', else the map's", "WORLD")] = None
    """What a collision is. paper: the centres closer than 1.5 m; paper-footprint: a body touches the car, which is
    usual on other maps than paper; campus: that too, a slow car, and people at a measured pace
    (docs: real-recordings); town: as paper-footprint, and a car for towns (50 km/h, harder brakes, slower in bends);
    blind-corner and arterial: that too, and people are hidden, and many run (docs: perception).
    Both kinds of contact are always counted."""
    people: Annotated[int | None, option("the run folders', else 12", "N")] = None
    """Pedestrians in an episode."""
    jaywalk_multiplier: Annotated[float | None, option("the world's", "X")] = None
    """P(jaywalk | decision) = jaywalking tendency x this: 1 where people are hidden, else 0.25."""
    tests: Annotated[str | None, option("none", "SUITE")] = None
    """Instead of an episode: the crash tests of a suite, or of FILE.toml or FILE.xosc, without a driver
    (docs: crash-tests). Only --layers and --out go with it."""
    layers: Annotated[tuple[str, ...], option("standard", "LAYER [LAYER ...]")] = ("standard",)
    """Which of the suite's tests: standard, extended, or a layer of robustness, such as faster; all: all of them."""
    out: Annotated[Path, option("scenario", "DIR")] = Path("scenario")
    """Folder for episode.xosc, map.xodr and commonroad.xml; of crash tests, a file for each run and map.xodr. Needs
    pip install "jaxwalk[scenarios]"."""
