"""The speed differential on scenes whose numbers are worked out by hand."""

from __future__ import annotations

import pytest

from jaxwalk.metrics import SPEED_DIFFERENTIAL, measure, summarise
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, trajectory


def bins(*scenes: Scene):
    return summarise(measure(trajectory(*scenes)), resamples=100)[SPEED_DIFFERENTIAL]


def test_a_jaywalker_and_a_crosswalk_user_at_once_give_each_frame_to_both():
    # the car stands at 0, frame by frame at other speeds only on paper: 1 step, both within their bins
    people = [Walk(2, 0, crossings=[(0, 1, JAYWALK)]), Walk(0, 4, crossings=[(0, 1, CROSSWALK)])]
    near, second, *_ = bins(Scene(1, people, speed=[4.0, 0.0]))
    assert (near.pooled.jaywalk.value, near.pooled.jaywalk.count) == (pytest.approx(2.0), 2)
    assert (near.pooled.crosswalk.value, near.pooled.crosswalk.count) == (None, 0)
    assert near.pooled.difference.value is None
    assert (second.pooled.crosswalk.value, second.pooled.crosswalk.count) == (pytest.approx(2.0), 2)


def test_only_the_nearest_of_a_type_counts_and_only_on_a_roadway():
    people = [
        Walk(0, 7, crossings=[(0, 1, JAYWALK)]),
        Walk(0, 4, crossings=[(0, 0, JAYWALK)]),  # the nearest in frame 0, gone in frame 1
        Walk(0, 1),
    ]
    summary = bins(Scene(1, people, speed=[6.0, 0.0]))
    assert [b.pooled.jaywalk.count for b in summary] == [0, 1, 1, 0]
    assert [b.pooled.jaywalk.value for b in summary] == [None, 6.0, 0.0, None]


@pytest.mark.parametrize(("distance", "place"), [(0, 0), (2.999, 0), (3, 1), (6, 2), (9, 3), (11.999, 3), (12, None)])
def test_bins_hold_their_near_edge(distance, place):
    summary = bins(Scene(1, [Walk(0, distance, crossings=[(0, 1, CROSSWALK)])], speed=0.0))
    assert [b.pooled.crosswalk.count for b in summary] == [2 if i == place else 0 for i in range(4)]
    assert [(b.near, b.far) for b in summary] == [(0, 3), (3, 6), (6, 9), (9, 12)]


def test_pooled_and_by_encounter():
    # three cars close in on somebody who stays 1 to 3 m away: 2 m/s for 4 frames, 8 m/s for 1 frame, 6 m/s for 2 frames
    def scene(kind: int, speed: float, frames: int, start: float) -> Scene:
        return Scene(frames, [Walk(start, 0, crossings=[(1, frames, kind)])], speed=speed)

    near = bins(scene(CROSSWALK, 2.0, 4, 2.9), scene(CROSSWALK, 8.0, 1, 2.9), scene(JAYWALK, 6.0, 2, 2.9))[0]
    assert near.pooled.crosswalk.value == pytest.approx((4 * 2 + 8) / 5)
    assert near.pooled.difference.value == pytest.approx(6 - 3.2)
    assert (near.pooled.crosswalk.count, near.pooled.difference.count) == (5, 2)
    assert near.by_encounter.crosswalk.value == pytest.approx((2 + 8) / 2)
    assert near.by_encounter.difference.value == pytest.approx(1.0)
    assert (near.by_encounter.crosswalk.count, near.by_encounter.jaywalk.count) == (2, 1)


def test_frames_outside_an_encounter_are_pooled_but_belong_to_no_encounter():
    # the car drives away from somebody behind it: near, but never closing
    near = bins(Scene(2, [Walk(-1, 0, crossings=[(0, 2, JAYWALK)])]))[0]
    assert (near.pooled.jaywalk.count, near.by_encounter.jaywalk.count) == (3, 0)


def test_intervals_resample_episodes():
    # two kinds of episodes, 2 and 6 m/s, ten each: the mean is 4, and its interval is near 4 +- 1.96 * 2 / sqrt(20)
    scenes = [Scene(1, [Walk(0, 2, crossings=[(0, 1, JAYWALK)])], speed=[v, v]) for v in (2.0, 6.0) * 10]
    estimate = summarise(measure(trajectory(*scenes)), resamples=2000)[SPEED_DIFFERENTIAL][0].pooled.jaywalk
    assert estimate.value == pytest.approx(4.0)
    assert (estimate.low, estimate.high) == (pytest.approx(4 - 0.88, abs=0.15), pytest.approx(4 + 0.88, abs=0.15))


def test_an_encounter_at_the_far_edge_of_the_last_bin_is_in_none():
    at_12_m = bins(Scene(1, [Walk(12.5, 0, crossings=[(1, 1, JAYWALK)])]))
    assert [one.by_encounter.jaywalk.count for one in at_12_m] == [0, 0, 0, 0]
    nearer = bins(Scene(1, [Walk(12.4, 0, crossings=[(1, 1, JAYWALK)])]))
    assert [one.by_encounter.jaywalk.count for one in nearer] == [0, 0, 0, 1]
