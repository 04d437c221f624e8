"""``jaxwalk frontier``."""

from __future__ import annotations

from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import Frontier
from jaxwalk.experiments.frontier_study import FrontierEffort, frontier_study


def run(options: Frontier) -> int:
    """Play everything that is missing; return 130 if Ctrl-C ended it."""
    with bad_values():
        plan = FrontierEffort(
            episodes=options.episodes, seed=options.seed, suites=options.suite, drivers=options.driver,
            shields=options.shield, pedestrians=options.pedestrians, own_settings=options.own_settings,
        )  # fmt: skip
    return until_interrupted(lambda: f"Read {frontier_study(options.out, plan, trust=options.trust)}")
