"""Two drivers, each trained with several prices of time, compared at equal delay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from jaxwalk.evaluation.comparison import check_same_scenarios
from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.harm_numbers import injuries
from jaxwalk.evaluation.training_seeds import Match
from jaxwalk.metrics import Rows
from jaxwalk.metrics.adjusted import at_equal_delay
from jaxwalk.metrics.contacts import touched_while_moving
from jaxwalk.metrics.delay import delays
from jaxwalk.metrics.over_seeds import linear_part

AT_EQUAL_DELAY: dict[str, Callable[[Rows], Float[np.ndarray, "scenario"]]] = {
    "moving contacts %": lambda rows: 100.0 * touched_while_moving(rows),
    "serious injuries in 1,000": injuries,
}
"""What is compared: the mean over scenarios."""


@dataclass(frozen=True)
class EqualDelay:
    """How much more of something B has than A, once both have the same delay (`jaxwalk.metrics.adjusted`)."""

    of: str
    """What is compared, one of `AT_EQUAL_DELAY`."""
    a: str
    b: str
    prices: int
    """Prices of time with which each was trained."""
    training_seeds: int
    later: float | None
    """Mean delay of B minus that of A, where all trainings of a seed arrive [s]; None if there is no such scenario."""
    slope_a: float | None
    """Change for each second of delay, within A's trainings of one seed."""
    slope_b: float | None
    difference: Interval
    """Number of B minus that of A at equal delay, by the slope of both; no value without delays that differ."""
    p: float | None
    """Two-sided p-value of the t-test over training seeds; None if it can't be judged."""


def equal_delay(of: str, a: Sequence[Sequence[Match]], b: Sequence[Sequence[Match]]) -> EqualDelay:
    """Compare A and B, each given as its trainings: for each price of time the matches of all seeds, in one order.

    Raises:
        ValueError: the trainings of A and B don't have the same seeds, or did not play the same scenarios.
    """
    seeds = {tuple(match.cell.training_seed for match in group) for group in (*a, *b)}
    if len(seeds) != 1:
        raise ValueError(
            f"A and B need the same training seeds with every price of time, not {sorted(map(str, seeds))}"
        )
    trainings = [match.rows for side in (a, b) for group in side for match in group]
    for rows in trainings:
        check_same_scenarios(trainings[0], rows)
    shape = (2, len(a), len(a[0]), -1)
    number = np.stack([AT_EQUAL_DELAY[of](rows) for rows in trainings]).reshape(shape)
    late = np.stack([delays(rows) for rows in trainings]).reshape(shape)
    arrived = np.logical_and.reduce(np.isfinite(late), axis=(0, 1))
    found, later = None, None
    if arrived.any(axis=-1).all():
        delay = np.stack([[linear_part(np.where(arrived, one, 0), arrived) for one in side] for side in late])
        found, later = at_equal_delay(delay, number), float(delay[1].mean() - delay[0].mean())
    slope_a, slope_b = (None, None) if found is None else found.slopes
    return EqualDelay(
        of=of,
        a=a[0][0].cell.driver,
        b=b[0][0].cell.driver,
        prices=len(a),
        training_seeds=len(a[0]),
        later=later,
        slope_a=slope_a,
        slope_b=slope_b,
        difference=Interval(None, None, None) if found is None else Interval.of(found),
        p=None if found is None else found.p,
    )
