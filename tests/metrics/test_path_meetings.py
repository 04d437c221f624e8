"""Meetings of a person's way and a car's path, on scenes whose numbers are worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.metrics import measure, summarise
from jaxwalk.metrics.path_meetings import PATH_MEETINGS, meeting_sums
from jaxwalk.sim.crossing_kind import JAYWALK
from metrics.scenes import DISC, Scene, Walk, trajectory

ACROSS = Walk(20, -3.05, vy=1.9, crossings=[(2, 30, JAYWALK)])
"""At -3.05 + 0.19 k m: on the path (1.5 m to either side) from frame 9, at -1.34 m, to frame 23, at 1.32 m.

The car, at 0.5 k m, is within 1.5 m of the first of these places from frame 39 on, at 19.5 m.
"""


def met(scene, **standing):
    """The measured rows; ``standing`` are frames in which the person's speed is said to be 0."""
    played = trajectory(scene)
    speed = played.ped_vy.copy()
    speed[standing.get("frames", [])] = 0
    return measure(replace(played, ped_vy=speed), config=DISC, metrics=(PATH_MEETINGS,))


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
    # In frame 33 (-2.78 m) the car is at 26.5 m, past the place that it covered from 19.5 m on, and 1.5 m.
    assert np.isnan(found.offered[0])


def test_the_summary_of_one_meeting():
    found = summarise(met(Scene(60, [ACROSS])))[PATH_MEETINGS]
    assert (found.waited.value, found.pedestrian_first.value) == (0, 1)
    assert found.accepted.value == pytest.approx(3)
    assert found.crossing_speed.value == pytest.approx(1.9)
