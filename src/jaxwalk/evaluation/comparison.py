"""Two evaluations on the same scenarios, compared scenario by scenario."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxwalk.metrics import Rows, mcnemar


@dataclass(frozen=True)
class Comparison:
    """How often one kind of ending happens in A and in B."""

    both: int
    """Scenarios that end so in both."""
    only_a: int
    only_b: int
    difference: float
    """Share in B minus share in A."""
    p: float
    """Exact McNemar p-value, two-sided."""


@dataclass(frozen=True)
class Paired:
    """The endings of the same scenarios under A and under B."""

    scenarios: int
    goal: Comparison
    collision: Comparison
    timeout: Comparison


def paired(rows_a: Rows, rows_b: Rows) -> Paired:
    """Compare two evaluations of the same scenarios (the same seed and street but for what is compared).

    Raises:
        ValueError: the scenarios are not the same ones in the same order.
    """
    a, b = rows_a.episodes, rows_b.episodes
    if not np.array_equal(a.scenario, b.scenario):
        raise ValueError("only evaluations of the same scenarios can be paired: use the same seed and episodes")
    return Paired(
        scenarios=len(a.scenario),
        goal=_compared(a.goal, b.goal),
        collision=_compared(a.collision, b.collision),
        timeout=_compared(~a.goal & ~a.collision, ~b.goal & ~b.collision),
    )


def _compared(a: np.ndarray, b: np.ndarray) -> Comparison:
    return Comparison(
        both=int((a & b).sum()),
        only_a=int((a & ~b).sum()),
        only_b=int((b & ~a).sum()),
        difference=float(b.mean() - a.mean()),
        p=mcnemar(a, b),
    )
