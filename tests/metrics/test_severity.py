"""The distributions of severity: counted by hand, and in agreement with the shares beyond critical thresholds."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from jaxwalk.metrics import SURROGATE_DISTRIBUTIONS, SURROGATES, measure, summarise
from jaxwalk.metrics.severity import THRESHOLDS, distribution_columns
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import DISC, Scene, Walk, trajectory
from metrics.test_properties import few, trajectories


def _rows(*scenes):
    return measure(trajectory(*scenes), config=DISC)


def _share(found, threshold):
    return found.value[found.threshold.index(threshold)]


def test_thresholds_are_those_of_results_made_before():
    """Another one would need another schema of results; 1.5 s (TTC, PET), 3 s, 3.4 m/s2 and 0 m are critical."""
    assert THRESHOLDS == {
        "ttc": (0.25, 0.5, 0.75, 1, 1.5, 2, 2.5, 3, 4, 5),
        "pet": (0.25, 0.5, 0.75, 1, 1.5, 2, 2.5, 3, 4, 5),
        "drac": (0, 0.5, 1, 1.5, 2, 2.5, 3, 3.4, 4, 5, 6, 8, 10),
        "gap": (0, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 5, 10, 15),
    }


def test_a_touch_beside_a_near_miss():
    # head-on at 6 m/s: TTC 0 and PET 0 after the touch, DRAC 60; the other crosses 1.2 s before the car
    hit = Scene(48, [Walk(30, 0, vx=-1, crossings=[(3, 48, JAYWALK)])], touched=[0])
    missed = Scene(80, [Walk(20, -4, vy=2, crossings=[(1, 39, JAYWALK)])])
    rows = _rows(hit, missed)
    found = summarise(rows, resamples=50)[SURROGATE_DISTRIBUTIONS]
    jaywalk = found.jaywalk
    assert [x.count for x in (jaywalk.ttc, jaywalk.pet, jaywalk.drac, jaywalk.gap)] == [2, 2, 2, 2]
    assert set(jaywalk.ttc.value) == {0.5}
    assert (_share(jaywalk.pet, 1.0), _share(jaywalk.pet, 1.5)) == (0.5, 1.0)
    assert set(jaywalk.drac.value) == {0.5}
    assert (_share(jaywalk.gap, 0), _share(jaywalk.gap, 15)) == (0.5, 1.0)
    assert (jaywalk.pet.low[0], jaywalk.pet.high[0]) == pytest.approx((0, 1))  # two episodes
    assert found.crosswalk.ttc.count == 0
    assert set(found.crosswalk.ttc.value + found.crosswalk.ttc.low) == {None}


def test_times_count_below_a_threshold_and_not_at_it():
    rows = _rows(Scene(80, [Walk(20, -4, vy=2, crossings=[(1, 39, JAYWALK)])]))
    table = rows[SURROGATES]
    at = np.full_like(table.ttc, 2.0)
    columns = distribution_columns(rows.having(SURROGATES, replace(table, ttc=at, pet=-at, drac=at)))
    ttc, pet, drac = (columns[name][0, JAYWALK - 1].tolist() for name in ("ttc", "pet", "drac"))
    assert ttc == pet == [0] * 6 + [1] * 4
    assert drac == [1] * 4 + [0] * 9


@few
@given(trajectories)
def test_they_agree_with_the_shares_beyond_critical_thresholds(world):
    summary = summarise(measure(world, config=DISC), resamples=5)
    for kind in ("crosswalk", "jaywalk"):
        found, shares = getattr(summary[SURROGATE_DISTRIBUTIONS], kind), getattr(summary[SURROGATES], kind)
        assert _share(found.ttc, 1.5) == shares.ttc_critical.value
        assert _share(found.pet, 1.5) == shares.pet_critical.value
        assert _share(found.pet, 3.0) == shares.pet_close.value
        assert _share(found.drac, 3.4) == shares.drac_critical.value
        for name in THRESHOLDS:
            known = [x for x in getattr(found, name).value if x is not None]
            assert np.all(np.diff(known) <= 0 if name == "drac" else np.diff(known) >= 0)


def test_the_document_has_them():
    walk = Walk(20, -4, vy=2, crossings=[(1, 39, CROSSWALK)])
    document = json.loads(json.dumps(summarise(_rows(Scene(80, [walk])), resamples=5).as_dict(), allow_nan=False))
    found = document["surrogate_distributions"]["crosswalk"]["gap"]
    assert list(found) == ["threshold", "value", "low", "high", "count"]
    assert len({len(found[name]) for name in ("threshold", "value", "low", "high")}) == 1
    assert found["value"][0] == pytest.approx(0.0)
