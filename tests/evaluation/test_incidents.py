"""The worst collisions and nearest misses are found, in order, and described."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from jaxwalk.evaluation import describe, find_incidents
from jaxwalk.metrics import measure
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, trajectory

FROM_THE_RIGHT = Walk(25.0, -4.0, vy=1.0, crossings=[(20, 50, JAYWALK)])
FROM_THE_LEFT = Walk(25.0, 4.0, vy=-1.0, crossings=[(20, 50, CROSSWALK)])
SCENES = (
    Scene(50, [FROM_THE_RIGHT], touched=[0], speed=5.0),  # 0: hit at 5 m/s
    Scene(50, [FROM_THE_LEFT], touched=[0], speed=8.0),  # 1: hit at 8 m/s
    Scene(50, [FROM_THE_RIGHT], touched=[0], speed=[5.0] * 50 + [0.0]),  # 2: walked into the standing car
    Scene(50, [Walk(25.0, -4.0, vy=0.85, crossings=[(20, 50, JAYWALK)])], goal=True, x=-4.0),  # 3: missed
    Scene(50, [Walk(0.0, 40.0)], goal=True),  # 4: met nobody
    Scene(50, [Walk(26.0, -3.0, vy=0.85, crossings=[(10, 50, JAYWALK)])], goal=True),  # 5: missed, nearer
)


@pytest.fixture(scope="module")
def played():
    return trajectory(*SCENES, scenario=[10, 11, 12, 13, 14, 15])


@pytest.fixture(scope="module")
def rows(played):
    return measure(played)


def test_the_worst_come_first(rows):
    found = find_incidents(rows, most=10)
    assert found.scenario.tolist() == [11, 10, 12, 15, 13]
    assert found.collision.tolist() == [True, True, True, False, False]
    assert found.contact.tolist() == [CROSSWALK, JAYWALK, JAYWALK, JAYWALK, JAYWALK]
    assert found.moving.tolist() == [True, True, False, False, False]
    assert found.risk[2] == 0
    assert found.risk[0] > found.risk[1] > 0
    assert np.isnan(found.risk[3:]).all()
    assert np.isnan(found.nearest[:3]).all()
    assert found.nearest[3] < found.nearest[4]


def test_no_more_than_asked_for_of_each_kind(rows):
    assert find_incidents(rows, most=1).scenario.tolist() == [11, 15]
    assert len(find_incidents(rows, most=0).scenario) == 0
    with pytest.raises(ValueError, match="most must be 0 or more, not -1"):
        find_incidents(rows, most=-1)


def test_situations(rows, played):
    found = find_incidents(rows, most=10)
    how = describe(found, played, moving_speed=0.5)
    assert how.side.tolist() == ["from the left", *["from the right"] * 4]
    assert how.car.tolist() == ["going straight", "going straight", "standing", "going straight", "going straight"]
    assert how.frame[:3].tolist() == [50, 50, 50]
    e, ped = 5, 0
    away = np.hypot(played.ped_x[:, e, ped] - played.car_x[:, e], played.ped_y[:, e, ped] - played.car_y[:, e])
    assert away[how.frame[3]] == away[found.first[3] : found.last[3] + 1].min()


@pytest.mark.parametrize(("sign", "words"), [(1, "turning left"), (-1, "turning right")])
def test_turns_show_in_the_heading(rows, played, sign, words):
    angle = sign * np.linspace(0, 2.0, len(played.car_x))[:, None] + 0 * played.car_x
    turning = dataclasses.replace(played, car_cos=np.cos(angle), car_sin=np.sin(angle))
    how = describe(find_incidents(rows, most=1), turning, moving_speed=0.5)
    assert how.car[0] == words


def test_a_scenario_that_was_not_played_is_named(rows, played):
    found = find_incidents(rows, most=10)
    other = dataclasses.replace(played, scenario=played.scenario + 100)
    with pytest.raises(ValueError, match="the trajectory lacks scenario 11"):
        describe(found, other, moving_speed=0.5)
