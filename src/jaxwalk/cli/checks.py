"""Checks of options that several commands share. Each raises UsageError, saying what is wrong and what to do."""

from __future__ import annotations

from collections.abc import Sequence, Sized
from dataclasses import fields
from pathlib import Path
from typing import Any

from jaxwalk.cli.errors import UsageError
from jaxwalk.runs.effort import MOST_EPISODES
from jaxwalk.sim.sim_config import LARGEST
from jaxwalk.sim.suites import SUITES, Where

DECIDED = ("episodes", "seed", "map", "world", "suite", "people", "jaywalk_multiplier")
"""Options that a file of scenarios decides."""
MOST_DRIVER_SECONDS = 86_400
"""Longest time that a driver may be given for one step [s]: a day."""


def check_driver(driver: str | Sequence[str]) -> None:
    """Raise UsageError unless a driver is named."""
    if not driver:
        raise UsageError(
            "--driver is missing: a name such as co-trained or route-follower, a run folder or a policy file"
        )


def check_pedestrians(pedestrians: Sequence[str]) -> None:
    """Raise UsageError unless a population is named."""
    if not pedestrians:
        raise UsageError("--pedestrians is missing: always-go, learned, a run folder or a policy file")


def check_episodes(episodes: int) -> None:
    """Raise UsageError unless there is at least one episode to play, and memory for the rows of all."""
    check_count("--episodes", episodes, 1, MOST_EPISODES)


def check_count(option: str, count: int, least: int, most: int) -> None:
    """Raise UsageError unless the value of an option lies between two numbers."""
    if not least <= count <= most:
        raise UsageError(f"{option} must lie in [{least}, {most:,}], not {count:,}")


def check_seed(seed: int) -> None:
    """Raise UsageError unless the seed can be one of a set of scenarios."""
    if not 0 <= seed < 2**31:
        raise UsageError(f"--seed must lie in [0, 2^31), not {seed}")


def check_scenario(scenario: int) -> None:
    """Raise UsageError unless the number can be a scenario's."""
    if not 0 <= scenario < 2**30:
        raise UsageError(f"--scenario must lie in [0, 2^30), not {scenario}")


def place(options: Any) -> Where:
    """Return where options ask to play: by a suite's name, or by maps, world and number of people.

    Raise UsageError for a suite beside what it decides, and for an impossible number of people.
    """
    maps = options.map if isinstance(options.map, tuple) else (options.map,) if options.map else ()
    asked, suite = Where(maps, options.world, options.people), getattr(options, "suite", None)
    if suite is None:
        if asked.people is not None:
            check_count("--people", asked.people, 1, LARGEST["pedestrians"])
        return asked
    given = {"map": asked.maps, "world": asked.world, "people": asked.people}
    for name in (name for name, value in given.items() if value):
        raise UsageError(f"--{name}: the suite {suite} decides it; leave it out, or leave out --suite")
    return SUITES[suite]


def check_number(scenario: int, kept: Sized | None) -> None:
    """Raise UsageError unless kept scenarios, if there are any, have this number."""
    if kept is not None and scenario >= len(kept):
        raise UsageError(f"--scenario {scenario}: the file has scenarios 0 to {len(kept) - 1}")


def check_kept(options: Any) -> None:
    """Raise UsageError for options that a file of scenarios decides."""
    usual = {field.name: field.default for field in fields(options)}
    for name in (name for name in DECIDED if name in usual and getattr(options, name) != usual[name]):
        raise UsageError(f"--{name.replace('_', '-')}: --scenarios {options.scenarios} decides it; leave it out")


def check_driver_seconds(seconds: float) -> None:
    """Raise UsageError unless the time limit of a driver is one that can be waited for."""
    if not 0 < seconds <= MOST_DRIVER_SECONDS:
        raise UsageError(f"--driver-seconds must be above 0 and at most {MOST_DRIVER_SECONDS:,}, not {seconds:g}")


def check_file(out: Path, suffix: str) -> None:
    """Raise UsageError unless ``--out`` names a file with that ending."""
    if out.suffix != suffix:
        raise UsageError(f"--out {out}: the name must end in {suffix}")
    check_no_folder(out)


def check_no_folder(out: Path) -> None:
    """Raise UsageError if ``--out`` names a folder where a file is needed."""
    if out.is_dir():
        raise UsageError(f"--out {out}: is a folder; name a file")
