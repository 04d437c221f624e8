"""``jaxwalk risk-aware``."""

from __future__ import annotations

from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import RiskAware
from jaxwalk.experiments.risk_aware import RiskEffort, risk_aware


def run(options: RiskAware) -> int:
    """Make everything that is missing; return 130 if Ctrl-C ended it."""
    with bad_values():
        sizes = {name: getattr(options, name) for name in ("updates", "episodes", "seed", "seeds")}
        plan = RiskEffort(**sizes)
    return until_interrupted(lambda: f"Read {risk_aware(options.out, plan)}")
