"""``jaxwalk hidden-intent``."""

from __future__ import annotations

import sys

from jaxwalk.cli.options import HiddenIntent
from jaxwalk.cli.train import bad_values
from jaxwalk.experiments.hidden_intent import Plan, hidden_intent
from jaxwalk.experiments.parts import Interrupted


def run(options: HiddenIntent) -> int:
    """Make everything that is missing; 130 if Ctrl-C ended it."""
    with bad_values():
        plan = Plan(updates=options.updates, episodes=options.episodes, seed=options.seed, seeds=options.seeds)
    try:
        made = hidden_intent(options.out, plan)
    except (Interrupted, KeyboardInterrupt):
        print("Interrupted. The same command goes on where this one stopped.", file=sys.stderr)
        return 130
    print(f"Read {made}")
    return 0
