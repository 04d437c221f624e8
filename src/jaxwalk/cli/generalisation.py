"""``jaxwalk generalisation``."""

from __future__ import annotations

from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import Generalisation
from jaxwalk.experiments.generalisation import GeneralisationEffort, generalisation


def run(options: Generalisation) -> int:
    """Make everything that is missing; return 130 if Ctrl-C ended it."""
    with bad_values():
        sizes = {name: getattr(options, name) for name in ("updates", "episodes", "seed", "seeds")}
        plan = GeneralisationEffort(**sizes)
    return until_interrupted(lambda: f"Read {generalisation(options.out, plan)}")
