"""The options of the command that lets people rate drivers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from jaxwalk.cli.options.declare import Flag, Suite, World, option


@dataclass(frozen=True)
class Rate:
    """Ask people which of two drivers drove more safely: makes a page of paired clips, and analyses the answers.

    For example: jaxwalk rate co-trained clearance careful-human, and when raters have sent their files:
    jaxwalk rate --answers answers-*.json
    """

    drivers: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="[D ...]")] = (
        "co-trained", "single-agent", "clearance", "careful-human", "route-follower",
    )  # fmt: skip
    """Two drivers or more, as in `jaxwalk evaluate` (default: five that come with jaxwalk)."""
    answers: Annotated[tuple[Path, ...], option("none", "FILE [FILE ...]")] = ()
    """Analyse these files, which raters saved, instead of making a page; --out names the page's folder."""
    pedestrians: Annotated[str, option("always-go", "P")] = "always-go"
    """The people in the clips, as in `jaxwalk evaluate`."""
    pairs: Annotated[int, option("25", "N")] = 25
    """Pairs that each rater sees; three of them come again with the sides swapped, and two checks."""
    episodes: Annotated[int, option("500", "N")] = 500
    """Scenarios that every driver plays: clips are chosen from them, and our own numbers are of them."""
    seed: Annotated[int, option("0", "N")] = 0
    """Which set of scenarios, and which choice of clips."""
    map: Annotated[tuple[str, ...], option("the run folders', else paper", "MAP [MAP ...]")] = ()
    """As in `jaxwalk evaluate`."""
    world: Annotated[World | None, option("the run folders', else the map's", "WORLD")] = None
    """As in `jaxwalk evaluate`."""
    suite: Annotated[Suite | None, option("none", "SUITE")] = None
    """Instead of --map, --world and --people: streets, car and crowd under one name (docs: suites)."""
    people: Annotated[int | None, option("the run folders', else 12", "N")] = None
    """Pedestrians in an episode."""
    jaywalk_multiplier: Annotated[float | None, option("the world's", "X")] = None
    """P(jaywalk | decision) = jaywalking tendency x this: 1 where people are hidden, else 0.25."""
    out: Annotated[Path, option("runs/rate", "DIR")] = Path("runs/rate")
    """Folder for rate.html, plan.json and, with --answers, ratings.md and ratings.json."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""
    driver_seconds: Annotated[float, option("10", "S")] = 10.0
    """Time limit of a driver that is not JAX for one step of its batch."""
