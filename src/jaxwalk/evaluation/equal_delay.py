"""Two drivers, each trained with several prices of time, compared at equal delay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.harm_numbers import injuries
from jaxwalk.evaluation.training_seeds import Match
from jaxwalk.metrics import Rows
from jaxwalk.metrics.adjusted import at_equal_delay
from jaxwalk.metrics.contacts import touched_while_moving
from jaxwalk.metrics.delay import delays

COMPARED: dict[str, Callable[[Rows], float]] = {
    "moving contacts %": lambda rows: 100 * float(touched_while_moving(rows).mean()),
    "serious injuries in 1,000": lambda rows: float(injuries(rows).mean()),
}
"""What is compared."""


@dataclass(frozen=True)
class EqualDelay:
    """How much more of something B has than A, once both have the same delay (`jaxwalk.metrics.adjusted`)."""

    of: str
    """What is compared, one of `COMPARED`."""
    a: str
    b: str
    settings: int
    """Prices of time with which each was trained."""
    training_seeds: int
    later: float | None
    """Mean delay of B minus that of A, over all trainings [s]; None if one of them never arrives."""
    slope: float | None
    """Change for each second of delay, within the trainings of one driver and seed."""
    difference: Interval
    """Number of B minus that of A at equal delay; without a value if some training has no delay, or all the same."""
    p: float | None
    """Two-sided p-value of the t-test over training seeds; None if it can't be judged."""


def equal_delay(of: str, a: Sequence[Sequence[Match]], b: Sequence[Sequence[Match]]) -> EqualDelay:
    """Compare A and B, each given as its trainings: for each price of time the matches of all seeds, in one order.

    Raises:
        ValueError: the trainings of A and B don't have the same seeds.
    """
    seeds = {tuple(match.cell.training_seed for match in group) for group in (*a, *b)}
    if len(seeds) != 1 or len(a) != len(b):
        raise ValueError(
            f"A and B need the same training seeds with every price of time, not {sorted(map(str, seeds))}"
        )
    delay, number = (np.stack([_means(measure, side) for side in (a, b)]) for measure in (_mean_delay, COMPARED[of]))
    found, later = at_equal_delay(delay, number), float(delay[1].mean() - delay[0].mean())
    return EqualDelay(
        of=of,
        a=a[0][0].cell.driver,
        b=b[0][0].cell.driver,
        settings=len(a),
        training_seeds=len(a[0]),
        later=later if np.isfinite(later) else None,
        slope=None if found is None else found.slope,
        difference=Interval(None, None, None) if found is None else Interval(found.value, found.low, found.high),
        p=None if found is None else found.p,
    )


def _means(measure: Callable[[Rows], float], trainings: Sequence[Sequence[Match]]) -> Float[np.ndarray, "setting seed"]:
    return np.array([[measure(match.rows) for match in group] for group in trainings])


def _mean_delay(rows: Rows) -> float:
    """Return the mean delay where the car arrives [s]; NaN if it never does."""
    found = delays(rows)
    known = found[~np.isnan(found)]
    return float(known.mean()) if len(known) else np.nan
