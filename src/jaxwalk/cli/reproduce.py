"""``jaxwalk reproduce``."""

from __future__ import annotations

import sys
from collections.abc import Callable

from jaxwalk.cli import INTERRUPTED
from jaxwalk.cli.options import Reproduce
from jaxwalk.cli.train import bad_values
from jaxwalk.experiments.reproduce import Plan, reproduce
from jaxwalk.runs.study import Interrupted


def run(options: Reproduce) -> int:
    """Make everything that is missing; 130 if Ctrl-C ended it."""
    with bad_values():
        plan = Plan(
            recipe=options.recipe, minutes=options.minutes, updates=options.updates, episodes=options.episodes,
            seed=options.seed, seeds=options.seeds,
        )  # fmt: skip
    return until_interrupted(lambda: f"Open {reproduce(options.out, plan)}")


def until_interrupted(make: Callable[[], str]) -> int:
    """Make something that can be gone on with, and print what ``make`` says of it; 130 if Ctrl-C ended it."""
    try:
        print(make())
    except (Interrupted, KeyboardInterrupt):
        print("Interrupted. The same command goes on where this one stopped.", file=sys.stderr)
        return INTERRUPTED
    return 0
