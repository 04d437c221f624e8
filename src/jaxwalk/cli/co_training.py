"""``jaxwalk co-training``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import CoTraining
from jaxwalk.experiments.co_training import CoTrainingEffort, co_training
from jaxwalk.experiments.paper_weights import SweepEffort, paper_weights


def run(options: CoTraining) -> int:
    """Make everything that is missing; return 130 if Ctrl-C ended it."""
    with bad_values():
        make = _chosen(options)
    return until_interrupted(lambda: f"Read {make()}")


def _chosen(options: CoTraining) -> Callable[[], Path]:
    """Return the study or the sweep that was asked for. Raise ValueError for an impossible size."""
    sizes = {"updates": options.updates, "seeds": options.seeds}
    asked = {name: size for name, size in sizes.items() if size is not None}
    asked |= {"episodes": options.episodes, "seed": options.seed}
    if options.sweep:
        return partial(paper_weights, options.out or Path("runs/paper-weights"), SweepEffort(**asked))
    return partial(co_training, options.out or Path("runs/co-training"), CoTrainingEffort(**asked))
