"""The likelihood of a tail, its test and its interval, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from jaxwalk.metrics.pareto_tail import Excesses, _fit_p, _log_likelihood, _profile, fit
from metrics.excesses import once


@pytest.mark.parametrize(
    ("shape", "density"),
    [
        (-1.0, [1, 1]),  # uniform
        (0.0, [2 * math.log(2) * 2**-0.5, 2 * math.log(2) * 2**-0.25]),  # 2 ln 2 exp(-y ln 2)
        (1.0, [2 / 1.5**2, 2 / 1.25**2]),  # 2 (1 + y)^-2
        (0.5, [4 * (2**0.5 - 1) / (1 + (2**0.5 - 1) * y) ** 3 for y in (0.5, 0.25)]),  # 2 (a / shape) (1 + a y)^-3
    ],
)
def test_the_likelihood_where_as_many_lie_beyond_as_within(shape, density):
    """Half of the excesses would be 1 or more: the other half's density is doubled."""
    found = _log_likelihood(once([0.5, 0.25]), 0.0, shape)
    assert found == pytest.approx(math.log(density[0]) + math.log(density[1]))


def test_the_likelihood_where_a_third_as_many_lie_beyond():
    """A quarter of the excesses would be 1 or more: of shape 1, (1 + 3 y)^-1 with the density 3 (1 + 3 y)^-2 / 0.75."""
    assert _log_likelihood(once([1 / 3]), -math.log(3), 1.0) == pytest.approx(0.0)
    assert _log_likelihood(once([1.0]), -math.log(3), 1.0) == pytest.approx(math.log(1 / 4))


@pytest.mark.parametrize("shape", [-1.0, 0.0, 0.5, 1.0])
@pytest.mark.parametrize(("counts", "square"), [([2] * 10, 0.0), ([3, 1] + [2] * 8, 1.0), ([4, 0] + [2] * 8, 4.0)])
def test_the_fit_is_tested_with_ten_equally_likely_cells(shape, counts, square):
    """Of 20 excesses two belong into each cell; ten cells less one, and two parameters, leave seven degrees."""
    below = np.repeat((np.arange(10) + 0.5) / 10, counts)  # share of the excesses within that are smaller
    survival = 1 - below / 2  # half of all lie beyond
    y = -np.log2(survival) if shape == 0 else (survival**-shape - 1) / (2**shape - 1)
    assert _fit_p(once(y), 0.0, shape) == pytest.approx(stats.chi2.sf(square, 7))


def test_the_ends_of_the_interval_are_less_likely_by_half_of_the_chi_square_quantile():
    y = stats.genpareto.ppf((np.arange(300) + 0.5) / 300 * 0.9, 0.1, scale=0.1 / (0.1**-0.1 - 1))  # a tenth lies beyond
    found = fit(once(2 * y), 2.0)
    best, low, high = (_profile(once(y), math.log(ratio))[0] for ratio in (found.ratio, found.low, found.high))
    assert (best - low, best - high) == pytest.approx((3.841 / 2, 3.841 / 2), abs=0.03)
    assert found.shape == pytest.approx(0.1, abs=0.05)


def test_an_excess_that_was_seen_twice_counts_twice():
    twice, both = Excesses(np.array([0.2, 0.6]), np.array([2, 1])), once([0.2, 0.2, 0.6])
    assert twice.count == 3
    for shape in (0.0, 0.5):
        assert _log_likelihood(twice, -1.0, shape) == pytest.approx(_log_likelihood(both, -1.0, shape))
        assert _fit_p(twice, -1.0, shape) == pytest.approx(_fit_p(both, -1.0, shape))
