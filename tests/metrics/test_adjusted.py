"""Two drivers as if both were equally quick: by hand, and how often the interval covers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from jaxwalk.metrics.adjusted import at_equal_delay

SEEDS = 5
DELAY = np.stack([np.tile([[1.0], [2.0], [3.0]], (1, SEEDS)), np.tile([[2.0], [3.0], [4.0]], (1, SEEDS))])
"""A is trained with three prices of time, and so is B, which is a second slower."""


def _numbers(of_seeds: float | np.ndarray = 0.0) -> np.ndarray:
    """Contacts fall by 2 for each second of delay; B has 3 less, and more or less by seed."""
    of_b = np.zeros_like(DELAY)
    of_b[1] = of_seeds - 3.0
    return 10 - 2 * DELAY + of_b


def test_by_hand():
    """Half a standard error of seeds that lie -2, -1, 0, 1 and 2 from their mean: 1.581 / 2.236 x 2.776 = 1.963."""
    found = at_equal_delay(DELAY, _numbers(np.arange(-2.0, 3.0)))
    assert found is not None
    assert (found.value, found.slope) == (pytest.approx(-3), pytest.approx(-2))
    assert (found.low, found.high) == (pytest.approx(-4.963, abs=0.001), pytest.approx(-1.037, abs=0.001))
    assert found.p == pytest.approx(2 * stats.t.sf(3 / np.sqrt(0.5), 4))


def test_without_the_slope_it_would_look_larger():
    numbers = _numbers()
    assert numbers[1].mean() - numbers[0].mean() == pytest.approx(-5)
    found = at_equal_delay(DELAY, numbers)
    assert found is not None
    assert found.value == pytest.approx(-3)
    assert (found.low, found.p) == (None, None), "nothing varies from seed to seed, so nothing says how much it would"


def test_what_cannot_be_judged():
    few = at_equal_delay(DELAY[..., :4], _numbers(np.arange(-2.0, 3.0))[..., :4])
    assert few is not None
    assert (few.low, few.high, few.p) == (None, None, None)
    assert at_equal_delay(DELAY[:, :1], _numbers()[:, :1]) is None, "one price of time shows no slope"
    never = DELAY.copy()
    never[0, 0, 0] = np.nan
    assert at_equal_delay(never, _numbers()) is None, "a car that never arrives has no delay"


def test_the_interval_covers():
    """Seeds, trainings and delays vary: of 1,000 studies, about 95 % of the intervals hold the true difference."""
    rng, found = np.random.default_rng(0), []
    for _ in range(1000):
        delay = DELAY + rng.normal(0, 0.4, DELAY.shape)
        number = 10 - 2 * delay + rng.normal(0, 0.5, DELAY.shape) + rng.normal(0, 0.5, (2, 1, SEEDS))
        number[1] -= 3
        found.append(at_equal_delay(delay, number))
    covered = np.mean([one.low <= -3 <= one.high for one in found])
    assert 0.93 <= covered <= 0.98, covered
