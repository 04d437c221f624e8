"""``jaxwalk hidden-intent``."""

from __future__ import annotations

from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import HiddenIntent
from jaxwalk.experiments.hidden_intent import IntentEffort, hidden_intent


def run(options: HiddenIntent) -> int:
    """Make everything that is missing; return 130 if Ctrl-C ended it."""
    with bad_values():
        plan = IntentEffort(
            updates=options.updates, episodes=options.episodes, seed=options.seed, seeds=options.seeds,
            recipe=options.recipe, cars=options.cars, time_weights=options.time_weights,
            pace_correlation=options.pace_correlation, only_as_trained=options.only_as_trained,
        )  # fmt: skip
    return until_interrupted(lambda: f"Read {hidden_intent(options.out, plan)}")
