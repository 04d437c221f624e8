"""Somebody who crosses a road alone, for tests that put the car near."""

from __future__ import annotations

import numpy as np
import pytest

from sim.maps import rectangles
from sim.play import alike, goal


def alone(state, p):
    """Distance of each person p to the nearest other one, by environment."""
    x, y = np.asarray(state.pedestrian.x), np.asarray(state.pedestrian.y)
    away = np.hypot(x - x[p], y - y[p])
    away[p] = np.inf
    return away.min(axis=0)


@pytest.fixture(scope="module")
def crossing_person(paid_street, scenarios, midway):
    """Somebody on a roadway, 5 m or more from others and from the goal: (scenario, state, person), everywhere alike."""
    people = midway.pedestrian
    x, y = np.asarray(people.x), np.asarray(people.y)
    goal_x, goal_y = goal(paid_street.world, scenarios)
    roads = rectangles("roads")
    for p, env in zip(*np.nonzero(np.asarray(people.on_roadway)), strict=True):
        far = np.hypot(goal_x[env] - x[p, env], goal_y[env] - y[p, env]) > 8
        room = min(abs(roads[:, 1] - y[p, env]).min(), abs(roads[:, 3] - y[p, env]).min()) > 2
        if alone(midway, p)[env] > 5 and far and room and 4 < x[p, env] < 116 and 52 < y[p, env] < 60:
            return alike(scenarios, env), alike(midway, env), p
    pytest.fail("nobody crosses the W-E road alone")
