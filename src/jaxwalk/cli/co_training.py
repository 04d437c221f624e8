"""``jaxwalk co-training``."""

from __future__ import annotations

from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import CoTraining
from jaxwalk.experiments.co_training import CoTrainingEffort, co_training


def run(options: CoTraining) -> int:
    """Make everything that is missing; return 130 if Ctrl-C ended it."""
    with bad_values():
        plan = CoTrainingEffort(
            updates=options.updates, episodes=options.episodes, seed=options.seed, seeds=options.seeds
        )
    return until_interrupted(lambda: f"Read {co_training(options.out, plan)}")
