"""Meetings of a person's way and a car's path, on scenes whose numbers are worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.metrics import measure, summarise
from jaxwalk.metrics.path_meetings import PATH_MEETINGS, meeting_sums
from jaxwalk.sim.crossing_kind import JAYWALK
from jaxwalk.sim.sim_config import SimConfig
from metrics.scenes import DISC, Scene, Walk, changed, trajectory, turned

ACROSS = Walk(20, -3.05, vy=1.9, crossings=[(2, 30, JAYWALK)])
"""At -3.05 + 0.19 k m: on the path (1.5 m to either side) from frame 9, at -1.34 m, to frame 23, at 1.32 m.

The car, at 0.5 k m, is within 1.5 m of the first of these places from frame 39 on, at 19.5 m.
"""


def met(scene, slow=0.0, **standing):
    """The measured rows; ``standing`` are frames in which the person's speed is said to be 0, or ``slow``."""
    played = trajectory(scene)
    speed = played.ped_vy.copy()
    speed[standing.get("frames", [])] = slow
    return measured(changed(played, ped_vy=speed))


def measured(played):
    return measure(played, config=DISC, metrics=(PATH_MEETINGS,))


def test_who_comes_first_accepts_what_the_car_still_needs():
    rows = met(Scene(60, [ACROSS]))
    found = rows[PATH_MEETINGS]
    assert found.accepted == pytest.approx([15 / 5])  # from 4.5 m in frame 9
    # Judged in frame 2, the first of at most 1.5 m before (7 x 0.19 m): from 1 m, and 1.5 m on, abreast of the place.
    assert found.offered == pytest.approx([20 / 5])
    assert (found.approach_seen.tolist(), found.waited.tolist()) == ([True], [False])
    assert found.pet[0] > 0
    assert found.crossing_speed == pytest.approx([1.9])
    sums = {name: x.tolist() for name, x in meeting_sums(rows).items()}
    assert sums == {"meetings": [1], "waited": [0], "first": [1]}


def test_the_mean_speed_is_that_on_the_roadway_alone():
    """29 frames on the roadway, 2 to 30: of those beside them none counts, of those at its ends each does."""
    beside, last, first = (met(Scene(60, [ACROSS]), frames=frames)[PATH_MEETINGS] for frames in ([0, 1, 31, 32], 30, 2))
    assert beside.crossing_speed == pytest.approx([1.9])
    assert last.crossing_speed == first.crossing_speed == pytest.approx([1.9 * 28 / 29])


def test_whoever_stood_for_half_a_second_before_the_path_has_waited():
    waits = [met(Scene(60, [ACROSS]), frames=range(4, 4 + count))[PATH_MEETINGS].waited[0] for count in (4, 5)]
    assert waits == [False, True]
    on_the_path = met(Scene(60, [ACROSS]), frames=range(9, 15))[PATH_MEETINGS]
    assert not on_the_path.waited[0]


def test_after_the_car_nobody_accepts_a_gap():
    late = Walk(20, -9.05, vy=1.9, crossings=[(20, 65, JAYWALK)])  # on the path from frame 40: -1.45 m
    found = met(Scene(70, [late], x=10))[PATH_MEETINGS]
    assert found.pet[0] < 0 and np.isnan(found.accepted[0])
    # In frame 33 (-2.78 m) the car is at 26.5 m, past the place that it covered from 20 m on, and 1.5 m.
    assert np.isnan(found.offered[0])


def test_the_summary_of_one_meeting():
    found = summarise(met(Scene(60, [ACROSS])))[PATH_MEETINGS]
    assert (found.waited.value, found.pedestrian_first.value) == (0, 1)
    assert found.accepted.value == pytest.approx(3)
    assert found.crossing_speed.value == pytest.approx(1.9)


def test_limits_of_place_are_not_on_the_path_but_near_enough_to_judge():
    """At 0.25 k - 3.5 m: 1.5 m beside the car's middle in frame 8, so on its path from frame 9 on, at -1.25 m. Six
    steps before, in frame 3, it is 1.5 m away. The car comes within 1.5 m of -1.25 m in frame 39, at 19.5 m."""
    found = met(Scene(60, [Walk(20, -3.5, vy=2.5, crossings=[(2, 30, JAYWALK)])]))[PATH_MEETINGS]
    assert found.accepted == pytest.approx([30 * 0.5 / 5])
    assert found.offered == pytest.approx([(36 * 0.5 + 1.5) / 5])


def test_who_walks_at_the_limit_does_not_stand():
    waits = [met(Scene(60, [ACROSS]), slow, frames=range(3, 9))[PATH_MEETINGS].waited[0] for slow in (0.5, 0.49)]
    assert waits == [False, True]


@pytest.mark.parametrize(("slow", "waited"), [(1.9, False), (0.0, True)])
def test_one_long_step_of_standing_is_a_stop(slow, waited):
    played = trajectory(Scene(60, [ACROSS], speed=10.0))
    speed = np.full_like(played.ped_vy, 1.9)
    speed[4] = slow
    assert measured(changed(played, ped_vy=speed, dt=0.5))[PATH_MEETINGS].waited.tolist() == [waited]


def test_the_car_may_come_5_s_later():
    # from -5.5 m in frame 9 to 19.5 m in frame 59; to somebody who is there in frame 10 it would be 4.9 s
    found = met(Scene(80, [ACROSS], x=-10))[PATH_MEETINGS]
    assert found.accepted == pytest.approx([5.0])


def test_who_is_on_the_path_with_the_car_was_not_first():
    """The car is at 19.5 m in frame 15, when the person is on its path; or in frame 28, half a second after it."""
    both, after = met(Scene(60, [ACROSS], x=12)), met(Scene(60, [ACROSS], x=5.5))
    assert (both[PATH_MEETINGS].pet, after[PATH_MEETINGS].pet) == (pytest.approx([0]), pytest.approx([0.5]))
    assert (meeting_sums(both)["first"].tolist(), meeting_sums(after)["first"].tolist()) == ([0], [1])
    assert np.isnan(both[PATH_MEETINGS].accepted[0])
    assert after[PATH_MEETINGS].accepted == pytest.approx([19 * 0.5 / 5])


@pytest.mark.parametrize(("last", "length"), [(9, 60), (30, 39)])
def test_the_last_frames_of_a_crossing_and_of_an_episode_count(last, length):
    """The person is on the path for one frame only; the car covers it in the last one."""
    found = met(Scene(length, [replace(ACROSS, crossings=[(2, last, JAYWALK)])]))[PATH_MEETINGS]
    assert found.accepted == pytest.approx([3.0])


@pytest.mark.parametrize(("x", "offered"), [(4.5, 0.1), (5.0, 0.0), (5.5, np.nan)])
def test_what_a_passing_car_still_offers(x, offered):
    """Judged in frame 33, on the path from frame 40 on: the car, at x + 0.5 k m, is abreast of it at 21.5 m."""
    late = Walk(20, -9.05, vy=1.9, crossings=[(20, 65, JAYWALK)])
    found = met(Scene(70, [late], x=x))[PATH_MEETINGS]
    assert found.offered == pytest.approx([offered], nan_ok=True)


def test_a_car_at_the_limit_of_moving_offers_time():
    """It is at 0.5 k - 0.45 m after frame 2, and covers the person's place from 19.55 m on, in frame 40."""
    found = [met(Scene(60, [ACROSS], speed=[5, 5, v] + [5] * 58))[PATH_MEETINGS].offered[0] for v in (0.5, 0.49)]
    assert found == pytest.approx([(19 + 1.5) / 0.5, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("first", "accepted", "offered", "before"), [(1, 3.0, 4.0, True), (8, 3.0, 3.4, False), (9, np.nan, 3.3, False)]
)
def test_what_was_not_in_view_was_not_judged(first, accepted, offered, before):
    """In view from a frame on: from the one before the judging one, from the last before the path, or on the path."""
    played = trajectory(Scene(60, [replace(ACROSS, crossings=[(first, 30, JAYWALK)])]))
    unseen = np.arange(61)[:, None, None] < first
    places = {name: np.where(unseen, np.nan, getattr(played, name)) for name in ("ped_x", "ped_y")}
    found = measured(changed(played, **places))[PATH_MEETINGS]
    assert found.accepted == pytest.approx([accepted], nan_ok=True)
    assert found.offered == pytest.approx([offered])
    assert found.approach_seen.tolist() == [before]


def test_nobody_was_seen_before_the_first_frame():
    """One step of 0.19 m farther on than `ACROSS`, it judges the car in frame 1, and two steps farther in frame 0."""
    seen = [
        met(Scene(60, [Walk(20, y, vy=1.9, crossings=[(2, 30, JAYWALK)])]))[PATH_MEETINGS].approach_seen.tolist()
        for y in (-2.86, -2.67)
    ]
    assert seen == [[True], [False]]


def test_a_turned_scene_has_the_same_times():
    found = measured(turned(trajectory(Scene(60, [ACROSS])), 1))[PATH_MEETINGS]
    assert (found.accepted, found.offered) == (pytest.approx([3.0]), pytest.approx([4.0]))


def test_the_way_left_is_that_of_the_last_steps():
    """Five steps of 1.19 m, then steps of 0.19 m: in frame 5 it has 0.76 m left, in frame 4 1.95 m."""
    played = trajectory(Scene(60, [ACROSS]))
    leaps = np.maximum(5 - np.arange(61), 0)[:, None, None]
    found = measured(changed(played, ped_y=played.ped_y - leaps))[PATH_MEETINGS]
    assert found.offered == pytest.approx([(34 * 0.5 + 1.5) / 5])


def test_a_car_of_usual_size():
    """4.5 m long, 1.8 m wide, the body 0.25 m: at 0.19 k - 3 m, it is on the path from frame 10 on, at -1.1 m.

    The car reaches 2.4 m ahead there, so from frame 36 on (18 m). Judged in frame 3; abreast is 2.5 m farther on.
    """
    played = trajectory(Scene(60, [Walk(20, -3.0, vy=1.9, crossings=[(2, 30, JAYWALK)])]))
    found = measure(played, config=SimConfig(), metrics=(PATH_MEETINGS,))[PATH_MEETINGS]
    assert found.accepted == pytest.approx([26 * 0.5 / 5])
    assert found.offered == pytest.approx([(33 * 0.5 + 2.5) / 5])
