"""Approaches and gaps at the kerb against worked examples: a car that drives east at 5 m/s from x = 0."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.metrics import APPROACHES, GAPS, WAITING, measure, summarise
from jaxwalk.metrics.approaches import CAR, NEITHER, PERSON
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, trajectory

ENTERS = {"kerb": range(4, 10), "crossings": [(10, 30, CROSSWALK)], "miss": 1.0}
"""At the kerb in frames 4 to 9, on the roadway from 10 on; the car is at x = 2 in frame 4."""
PEOPLE = {
    "goes": Walk(22.0, 0.0, **ENTERS),  # never waits: 4 s away at first, 17.5 m and 3.5 s in its last moment
    "waits, then goes": Walk(22.0, 0.0, waits=range(5, 8), **ENTERS),
    "lets the car pass": Walk(
        6.0, 3.0, waits=range(5, 20), kerb=range(4, 20), crossings=[(20, 30, CROSSWALK)], miss=1.0
    ),
    "waits to the end": Walk(32.0, 0.0, waits=range(5, 31), kerb=range(4, 31), miss=1.0),
    "never in danger": Walk(22.0, 0.0, kerb=range(4, 10), crossings=[(10, 30, CROSSWALK)]),
    "jaywalks": Walk(22.0, 0.0, kerb=range(4, 10), crossings=[(10, 30, JAYWALK)], miss=1.0),
}


@pytest.fixture(scope="module")
def rows():
    return measure(trajectory(*(Scene(30, [walk]) for walk in PEOPLE.values())))


def test_each_approach_with_a_dangerous_moment_is_a_row(rows):
    table = rows[APPROACHES]
    assert table.episode.tolist() == [0, 1, 2, 3, 5]
    assert table.waited.tolist() == [False, True, True, True, False]
    assert table.entered.tolist() == [True, True, False, False, True]
    assert table.before.tolist() == [PERSON, PERSON, CAR, NEITHER, PERSON]
    assert table.crosswalk.tolist()[:3] == [True, True, True] and not table.crosswalk[4]


def test_shares_of_approaches(rows):
    found = summarise(rows, resamples=50)[APPROACHES]
    assert (found.waited.value, found.waited.count) == (0.6, 5)
    assert (found.entered_in_danger.value, found.entered_in_danger.count) == (0.6, 5)
    assert (found.yielded.value, found.yielded.count) == (pytest.approx(2 / 3), 3)


def test_whoever_waits_long_counts_once():
    long, short = (Walk(32.0, 0.0, waits=range(5, 31), kerb=range(4, 31), miss=1.0), Walk(22.0, 0.0, **ENTERS))
    found = summarise(measure(trajectory(Scene(30, [long, short]))), resamples=20)
    assert found[APPROACHES].waited.value == 0.5
    assert found[WAITING].danger.value == pytest.approx(26 / 32)


def test_who_is_hit_was_not_yielded_to():
    hit = measure(trajectory(Scene(30, [PEOPLE["goes"]], touched=[0])))
    assert hit[APPROACHES].hit.tolist() == [True]
    assert summarise(hit, resamples=20)[APPROACHES].yielded.value == 0
    # a second stay at a kerb comes between: the first crossing was safe
    twice = Walk(
        22.0, 0.0, kerb=[*range(4, 10), *range(20, 25)], crossings=[(10, 15, CROSSWALK), (25, 30, CROSSWALK)], miss=1.0
    )
    assert measure(trajectory(Scene(30, [twice], touched=[0])))[APPROACHES].hit.tolist() == [False, True]


def test_gaps_are_times_for_the_front_to_come_abreast(rows):
    table = rows[GAPS]
    # frame 9: the car is at 4.5, its front 2.25 m ahead; who waits for frames 5 to 7 lets a gap of 3.55 s pass first
    assert table.accepted[[0, 1, 5]] == pytest.approx(15.25 / 5)
    assert table.rejected[[1, 2, 3]] == pytest.approx([3.55, 0.35, 5.55])
    assert np.isnan(table.rejected[[0, 4, 5]]).all()
    assert np.isnan(table.accepted[[2, 3]]).all()  # the car is past, and nobody entered
    found = summarise(rows, resamples=20)[GAPS]
    assert (found.accepted.value, found.accepted.count, found.rejected.value) == (
        pytest.approx(3.05),
        4,
        pytest.approx(3.55),
    )


def test_a_slow_car_leaves_no_gap():
    slow = measure(trajectory(Scene(30, [PEOPLE["goes"]], speed=2.0)))
    assert np.isnan(slow[GAPS].accepted).all()
    assert summarise(slow, resamples=20)[GAPS].accepted.value is None


def test_one_frame_on_the_roadway_is_enough_and_must_follow_at_once():
    step = Walk(22.0, 0.0, kerb=range(4, 10), crossings=[(10, 10, CROSSWALK)], miss=1.0)
    later = Walk(22.0, 0.0, kerb=range(4, 9), crossings=[(10, 30, CROSSWALK)], miss=1.0)
    rows = measure(trajectory(Scene(30, [step]), Scene(30, [later])))
    assert rows[APPROACHES].entered.tolist() == [True, False]
    assert rows[APPROACHES].before.tolist() == [PERSON, NEITHER]
    assert np.isnan(rows[GAPS].accepted).tolist() == [False, True]


@pytest.mark.parametrize(("last", "before"), [(11, NEITHER), (12, CAR)])
def test_a_car_abreast_has_passed(last, before):
    """The car, at 0.5 k m, is 0.5 m before the person in frame 11, and abreast in frame 12."""
    walk = Walk(6.0, 3.0, waits=range(5, 30), kerb=range(4, last + 1), miss=1.0)
    assert measure(trajectory(Scene(30, [walk])))[APPROACHES].before.tolist() == [before]


def test_a_stay_of_somebody_else_comes_to_no_other_kerb():
    once = Walk(22.0, 3.0, kerb=range(4, 10), miss=1.0)
    twice = Walk(
        22.0, 0.0, kerb=[*range(4, 10), *range(20, 25)], crossings=[(10, 15, CROSSWALK), (25, 30, CROSSWALK)], miss=1.0
    )
    table = measure(trajectory(Scene(30, [once, twice], touched=[0, 1])))[APPROACHES]
    assert table.hit.tolist() == [True, False, True]


@pytest.mark.parametrize(("place", "gap"), [(6.75, np.nan), (7.25, 0.1), (44.25, 7.5), (44.5, np.nan)])
def test_a_gap_is_before_the_front_and_within_40_m(place, gap):
    """In frame 9 the car is at 4.5 m and its front at 6.75 m; the first is abreast of the front, the last 40 m away."""
    table = measure(trajectory(Scene(30, [Walk(place, 0.0, **ENTERS)])))[GAPS]
    assert table.accepted == pytest.approx([gap], nan_ok=True)
