"""``jaxwalk reproduce``."""

from __future__ import annotations

from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import Reproduce
from jaxwalk.experiments.reproduce import Plan, reproduce


def run(options: Reproduce) -> int:
    """Make everything that is missing; return 130 if Ctrl-C ended it."""
    with bad_values():
        plan = Plan(
            recipe=options.recipe, minutes=options.minutes, updates=options.updates, episodes=options.episodes,
            seed=options.seed, seeds=options.seeds,
        )  # fmt: skip
    return until_interrupted(lambda: f"Open {reproduce(options.out, plan)}")
