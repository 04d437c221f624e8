"""A quick slice of ``tests/reliability/coverage.py``: exact probabilities, and a few simulations of the rest."""

from __future__ import annotations

import pytest

from reliability.coverage import EXACT, NEAR, Regime, measure, regimes, share_covers, sound

ALL = {f"{one.interval}, {one.data}": one for one in regimes()}


@pytest.mark.parametrize("name", [name for name, one in ALL.items() if one.exact])
def test_intervals_of_counts_cover(name):
    assert sound(ALL[name], *measure(ALL[name], 1, 0))


@pytest.mark.parametrize(
    "name",
    [
        "share of moments at the kerb, 10 of some 2000",
        "rate over training seeds, 5 seeds, 10 in each",
        "its test: no difference found, 5 seeds, 10 in each, scenarios differ",
        pytest.param("contacts extrapolated from near misses, 10 of 2000, shape 0", marks=pytest.mark.long),
        "speed in the worst contacts, 20 contacts of 2000",
    ],
)
def test_simulated_intervals_cover(name):
    assert sound(ALL[name], *measure(ALL[name], 150, 1))


def test_what_does_not_cover_is_found():
    """The bootstrap of one expected event is [0, 0] in 37 % of cases."""
    normal = Regime("normal", "", lambda rng: rng.poisson(1) > 0, EXACT)
    assert not sound(normal, *measure(normal, 150, 0))
    wide = Regime("wide", "", lambda rng: True, NEAR)
    assert not sound(wide, *measure(wide, 1000, 0))


@pytest.mark.parametrize("expected", [3, 5, 7, 9, 12, 15, 30])
def test_a_share_covers_where_exact_and_wilsons_intervals_meet(expected):
    assert share_covers(expected, 2000) > NEAR[0]
