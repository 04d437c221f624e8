"""``jaxwalk report``."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from jaxwalk.cli.casting import cast
from jaxwalk.cli.checks import check_count, check_driver_seconds, check_episodes, check_seed
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import Report
from jaxwalk.experiments.driver_report import driver_report
from jaxwalk.experiments.reproduce import report as remake
from jaxwalk.exports.gallery import Cast
from jaxwalk.policies.shield_names import with_shield
from jaxwalk.runs.effort import MOST_EPISODES
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held

MOST_POPULATIONS, MOST_INCIDENTS = 3, 200
"""Largest numbers of populations and of incidents that fit into the figures and into a page."""


def run(options: Report) -> int:
    """Make the report; make it again if given a folder of `jaxwalk reproduce`."""
    again = [Path(name) for name in options.runs if (Path(name) / "plan.json").is_file()]
    if again:
        if len(options.runs) > 1:
            raise UsageError(f"{again[0]}: a folder of `jaxwalk reproduce` is reported on its own; name it alone")
        if options != Report(runs=options.runs):
            raise UsageError(f"{again[0]}: --episodes and all other options are those of its `jaxwalk reproduce`")
        print(f"Open {_again(again[0])}")
        return 0
    check(options)
    names = with_shield(options.runs, options.shield)
    console = Console(stderr=True)

    def say(line: str) -> None:
        console.print(line, soft_wrap=True, markup=False)

    say("    loading drivers and the street")
    street, drivers, people = cast(
        names, options.pedestrians, options, trust=options.trust, seconds=options.driver_seconds
    )
    evaluated = Cast(street, drivers, people, options.seed)
    page = driver_report(
        options.out, evaluated, episodes=options.episodes, most=options.incidents, replays=options.counterfactuals,
        say=say,
    )  # fmt: skip
    print(f"Open {page}")
    return 0


def _again(folder: Path) -> Path:
    """Make the report of a folder of `jaxwalk reproduce` again; return its path."""
    with held(folder):
        return remake(folder)


def check(options: Report) -> None:
    """Raise an error for impossible options."""
    if not 1 <= len(options.pedestrians) <= MOST_POPULATIONS:
        raise UsageError(f"--pedestrians takes 1 to {MOST_POPULATIONS} populations, not {len(options.pedestrians)}")
    check_episodes(options.episodes)
    check_count("--incidents", options.incidents, 0, MOST_INCIDENTS)
    check_count("--counterfactuals", options.counterfactuals, 0, MOST_EPISODES)
    check_driver_seconds(options.driver_seconds)
    check_seed(options.seed)
    check_writable(options.out)
