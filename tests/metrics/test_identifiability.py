"""How much could be known of a tendency: against adaptive integration, simulation, and the driver's belief."""

from __future__ import annotations

from itertools import pairwise

import jax.numpy as jnp
import numpy as np
import pytest
from scipy import integrate, stats

from jaxwalk.metrics.crossings import find_crossings
from jaxwalk.metrics.identifiability import crossings_of_people, identifiability
from jaxwalk.sim.belief import posterior
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, trajectory

MULTIPLIERS = (0.25, 1.0, 1.6)
PRIOR_VARIANCE = 1 / 12
"""Of a number that is uniform in [0, 1]."""


def known(crossings, multiplier):
    return identifiability(np.atleast_1d(crossings), multiplier)


@pytest.mark.parametrize("multiplier", [0.0, *MULTIPLIERS])
def test_nothing_seen_nothing_known(multiplier):
    found = known([0, 0], multiplier)
    assert (found.people, found.crossings, found.never) == (2, 0, 1)
    assert (found.deviation, found.explained, found.bits) == pytest.approx((PRIOR_VARIANCE**0.5, 0, 0), abs=1e-12)


def test_where_nobody_jaywalks_nothing_is_learned():
    assert (known(30, 0.0).explained, known(30, 0.0).bits) == pytest.approx((0, 0), abs=1e-12)


def test_one_crossing_of_who_does_as_they_intend():
    """With multiplier 1, by hand: after either outcome the variance is 1/18, a third less; the information is
    1 - integral of the entropy of tau = 1 - 1 / (2 ln 2)."""
    found = known(1, 1.0)
    assert (found.deviation, found.explained) == pytest.approx((18**-0.5, 1 / 3))
    assert found.bits == pytest.approx(1 - 1 / (2 * np.log(2)), abs=1e-6)


def test_one_crossing_of_who_jaywalks_for_sure_from_half_the_tendency_on():
    """With multiplier 2, by hand: after a jaywalk (3 in 4) tau has mean 11/18 and square 31/72, so variance 37/648;
    else it is the lower half of a triangle, of variance 1/72. The mean is 3/4 x 37/648 + 1/4 x 1/72 = 5/108, and only
    where tau is below a half is the outcome uncertain: 1 / (4 ln 2) bits on average."""
    found = known(1, 2.0)
    assert found.explained == pytest.approx(1 - 12 * 5 / 108, abs=1e-12)
    assert found.deviation == pytest.approx(0.75 * (37 / 648) ** 0.5 + 0.25 * (1 / 72) ** 0.5, abs=1e-12)
    assert found.bits == pytest.approx(2 - 0.75 * np.log2(3) - 1 / (4 * np.log(2)), abs=1e-6)


@pytest.mark.parametrize("multiplier", MULTIPLIERS)
@pytest.mark.parametrize("crossings", [1, 4, 9])
def test_information_is_the_integral(crossings, multiplier):
    def probability(k, tau):
        return stats.binom.pmf(k, crossings, min(1.0, multiplier * tau))

    def integral(of):
        ends = (0, min(1.0, 1 / multiplier), 1)
        return sum(integrate.quad(of, low, high, epsrel=1e-9)[0] for low, high in pairwise(ends))

    bits = 0.0
    for k in range(crossings + 1):
        seen = integral(lambda tau, k=k: probability(k, tau))
        bits += integral(lambda tau, k=k, seen=seen: _surprise(probability(k, tau), seen))
    assert known(crossings, multiplier).bits == pytest.approx(bits, abs=1e-6)


def _surprise(p, seen):
    return p * np.log2(p / seen) if p > 0 else 0.0


@pytest.mark.parametrize("multiplier", MULTIPLIERS)
def test_as_many_people_show(multiplier):
    """Draw tendencies and crossings; the mean square error of the driver's belief is the posterior variance."""
    random = np.random.default_rng(1)
    crossings = random.integers(0, 7, 50_000)
    tau = random.random(len(crossings))
    jaywalks = random.binomial(crossings, np.minimum(1, multiplier * tau))
    mean, deviation = posterior(jnp.asarray(jaywalks), jnp.asarray(crossings - jaywalks), jnp.float32(multiplier))
    found = identifiability(crossings, multiplier)
    assert found.deviation == pytest.approx(float(deviation.mean()), abs=1e-3)
    assert found.explained == pytest.approx(1 - ((tau - np.asarray(mean)) ** 2).mean() / PRIOR_VARIANCE, abs=0.02)
    assert found.never == (crossings == 0).mean()


def test_of_two_tendencies_one_crossing_tells_nearly_all():
    """Three in ten jaywalk always and the others never: 2 values, 0.3 log2(1 / 0.3) + 0.7 log2(1 / 0.7) bits."""
    found = identifiability(np.array([1]), 1.0, {1.0: 0.3, 0.0: 0.7})
    assert (found.deviation, found.explained) == pytest.approx((0, 1), abs=1e-7)
    assert found.bits == pytest.approx(0.3 * np.log2(1 / 0.3) + 0.7 * np.log2(1 / 0.7))
    before = identifiability(np.array([0]), 1.0, {0.9: 0.3, 0.02: 0.7})
    assert (before.deviation, before.explained) == pytest.approx((0.88 * 0.21**0.5, 0))


def test_a_tendency_that_all_share_cannot_be_explained():
    assert identifiability(np.array([3]), 1.0, {0.9: 1.0}).explained == 0


def test_more_is_better():
    for multiplier in MULTIPLIERS:
        rows = [known(n, multiplier) for n in (0, 1, 2, 5, 20, 100)]
        assert (np.diff([row.bits for row in rows]) > 0).all()
        assert (np.diff([row.deviation for row in rows]) < 0).all()


def test_people_average():
    parts, both = (known(2, 0.5), known(6, 0.5)), known([2, 6, 6], 0.5)
    for name in ("crossings", "deviation", "explained", "bits"):
        first, second = (getattr(part, name) for part in parts)
        assert getattr(both, name) == pytest.approx((first + 2 * second) / 3)


def test_who_crossed_how_often():
    """Somebody on the road from the start wasn't seen to enter."""
    crossing = [(1, 5, CROSSWALK), (8, 9, JAYWALK)]
    first = Scene(12, [Walk(0, 5), Walk(0, 9, crossings=crossing), Walk(0, 7, crossings=[(0, 4, JAYWALK)])])
    second = Scene(12, [Walk(0, 5, crossings=crossing[:1]), Walk(0, 9), Walk(0, 7)])
    table, _ = find_crossings(trajectory(first, second))
    np.testing.assert_array_equal(crossings_of_people(table, episodes=2, people=3), [0, 2, 0, 1, 0, 0])


@pytest.mark.parametrize(("crossings", "multiplier"), [([], 0.25), ([-1], 0.25), ([1], -0.1)])
def test_impossible(crossings, multiplier):
    with pytest.raises(ValueError, match="must be there and not negative"):
        identifiability(np.array(crossings, int), multiplier)
