"""Two drivers as if both were equally quick: by hand, and how often the interval covers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from jaxwalk.metrics.adjusted import at_equal_delay

SEEDS = 5
DELAY = np.stack(
    [np.tile([[[1.0]], [[2.0]], [[3.0]]], (1, SEEDS, 1)), np.tile([[[2.0]], [[3.0]], [[4.0]]], (1, SEEDS, 1))]
)
"""A is trained with three prices of time, and so is B, which is a second slower; one scenario."""


def _numbers(of_seeds: float | np.ndarray = 0.0) -> np.ndarray:
    """Contacts fall by 2 for each second of delay; B has 3 less, and more or less by seed."""
    of_b = np.zeros_like(DELAY)
    of_b[1, ..., 0] = of_seeds - 3.0
    return 10 - 2 * DELAY + of_b


def test_by_hand():
    """Half an interval of seeds that lie -2, -1, 0, 1 and 2 from their mean: 1.581 / 2.236 x 2.776 = 1.963."""
    found = at_equal_delay(DELAY, _numbers(np.arange(-2.0, 3.0)))
    assert found is not None
    assert (found.value, found.slope, found.slopes) == (pytest.approx(-3), pytest.approx(-2), pytest.approx((-2, -2)))
    assert (found.low, found.high) == (pytest.approx(-4.963, abs=0.001), pytest.approx(-1.037, abs=0.001))
    assert found.p == pytest.approx(2 * stats.t.sf(3 / np.sqrt(0.5), 4))


def test_without_the_slope_it_would_look_larger():
    numbers = _numbers()
    assert numbers[1].mean() - numbers[0].mean() == pytest.approx(-5)
    found = at_equal_delay(DELAY, numbers)
    assert found is not None
    assert found.value == pytest.approx(-3)


def test_an_uncertain_slope_widens_the_interval():
    """Slopes of 0, -3, -4, -3 and 0 by seed: B is a second slower, so they matter by sqrt(10 + 14) / sqrt(10) = 1.55.

    Where both are equally quick they don't matter.
    """
    wobble = np.zeros_like(DELAY)
    wobble[:, :, :, 0] = np.array([-1.0, 0.0, 1.0])[:, None] * np.array([2.0, -1.0, -2.0, -1.0, 2.0])
    numbers = _numbers(np.arange(-2.0, 3.0))
    apart, level = at_equal_delay(DELAY, numbers + wobble), at_equal_delay(DELAY[[0, 0]], numbers + wobble)
    plain = at_equal_delay(DELAY, numbers)
    assert apart.value == pytest.approx(plain.value)
    width, of_level, of_plain = (one.high - one.low for one in (apart, level, plain))
    assert width == pytest.approx(1.549 * of_plain, rel=1e-3)
    assert of_level == pytest.approx(of_plain)


def test_what_cannot_be_judged():
    few = at_equal_delay(DELAY[:, :, :4], _numbers(np.arange(-2.0, 3.0))[:, :, :4])
    assert few is not None
    assert (few.low, few.high, few.p) == (None, None, None)
    assert at_equal_delay(DELAY[:, :1], _numbers()[:, :1]) is None, "one price of time shows no slope"
    never = DELAY.copy()
    never[0, 0, 0] = np.nan
    assert at_equal_delay(never, _numbers()) is None, "a car that never arrives has no delay"


@pytest.mark.parametrize("common", [0.0, 0.9])
def test_the_interval_covers(common):
    """Trainings, delays and scenarios vary: of 200 studies, about 95 % of the intervals hold the true difference.

    ``common``: share of the scenarios that end alike for all trainings of a car.
    """
    rng, prices, scenarios, covered = np.random.default_rng(0), (2, 3, SEEDS), 1000, 0
    for _ in range(200):
        delay = DELAY[..., 0] + rng.normal(0, 0.3, prices)
        rate = 0.12 - 0.02 * delay + rng.normal(0, 0.005, prices) + rng.normal(0, 0.004, (2, 1, SEEDS))
        alike = rng.random((2, 1, 1, scenarios)) < common
        chance = np.where(alike, rng.random((2, 1, 1, scenarios)), rng.random((*prices, scenarios)))
        each = delay[..., None] + rng.normal(0, 1.5, scenarios) + rng.normal(0, 0.5, (*prices, scenarios))
        found = at_equal_delay(each, (chance < rate[..., None]).astype(float))
        covered += found.low <= 0 <= found.high
    assert 180 < covered < 200, covered


def test_each_drivers_slope_and_the_common_one():
    """A's numbers fall by 2 and B's by 4 for each second; from 7 to 1 at 2, 3 and 4 s, B's mean is 4 and A's 6."""
    numbers = _numbers()
    numbers[1] = 13 - 4 * DELAY[1] + 2
    found = at_equal_delay(DELAY, numbers)
    assert (found.slopes, found.slope) == (pytest.approx((-2, -4)), pytest.approx(-3))
    assert found.value == pytest.approx(3 - 6 + 3)  # a second slower, at 3 for each
    assert found.low is None, "seeds don't differ"


def test_delays_may_vary_little():
    found = at_equal_delay(DELAY / 10, _numbers(np.arange(-2.0, 3.0)))
    assert (found.value, found.slope) == (pytest.approx(-3), pytest.approx(-20))


def test_what_a_seed_does_through_its_delay_does_not_count():
    """B's seeds are quicker or slower by up to 2 s: at equal delay they lie -2, -1, 0, 1 and 2 from their mean."""
    delay = DELAY.copy()
    delay[1, :, :, 0] += np.arange(-2.0, 3.0)
    numbers = _numbers(np.arange(-2.0, 3.0)) - 2 * (delay - DELAY)
    found = at_equal_delay(delay, numbers)
    assert (found.low, found.high) == (pytest.approx(-4.963, abs=0.001), pytest.approx(-1.037, abs=0.001))


def test_a_seeds_own_slope_may_make_up_for_its_level():
    """Seeds lie -2 to 2 from the mean, and their slopes -1 to 1: for a second, half of each difference remains."""
    numbers = _numbers(np.arange(-2.0, 3.0))
    numbers[..., 0] += np.array([-0.5, 0.0, 0.5])[:, None] * np.arange(-2.0, 3.0)
    found = at_equal_delay(DELAY, numbers)
    assert (found.low, found.high) == (
        pytest.approx(-3 - 1.963 / 2, abs=0.001),
        pytest.approx(-3 + 1.963 / 2, abs=0.001),
    )
