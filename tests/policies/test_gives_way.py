"""People who give way just before a car's path, which is 1.15 m to either side of its line."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.policies import POPULATIONS
from jaxwalk.policies.gives_way import GivesWay, GivingWay
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import part, size
from jaxwalk.sim.pedestrian_features import KERB_CAR_DISTANCE

PEOPLE = 2000
CAMPUS = GivesWay()


def beside(ahead, left=2.0, speed=2.5, *, to_kerb=-1.0, decides=0.0, aside=-1.0):
    """What people on a roadway see of a car, who walk to the right across its path."""
    seen = np.zeros((size("pedestrian", "kerb"), PEOPLE, 1), np.float32)
    rows = {
        "decides": [decides], "place": [ahead / KERB_CAR_DISTANCE, left / KERB_CAR_DISTANCE],
        "car_motion": [speed / SPEED, 0, 0], "direction": [0, aside], "to_kerb": [to_kerb],
    }  # fmt: skip
    for name, values in rows.items():
        seen[part("pedestrian", "kerb", name)] = np.array(values)[:, None, None]
    return seen


def going(seen, critical=3.8, steps=0):
    """Return the share who go, of people who have this critical gap and have given way for so many steps."""
    return jax.tree.map(np.asarray, _going(seen, np.float32(critical), np.int32(steps)))


@eqx.filter_jit
def _going(seen, critical, steps):
    memory = GivingWay(jnp.full((PEOPLE, 1), critical), jnp.full((PEOPLE, 1), steps))
    go, after = CAMPUS.act(jax.random.split(jax.random.key(0), 1), memory, seen)
    return go.mean(), after


def test_half_accept_a_gap_of_3_8_seconds():
    _, after = going(beside(40.0, left=10.0))
    assert float((after.critical < 4.33 / 1.14).mean()) == pytest.approx(0.5, abs=0.04)


@pytest.mark.parametrize("place", [{}, {"to_kerb": 1.0, "decides": 1.0}])
def test_they_walk_at_half_their_pace_before_the_path(place):
    """2.6 s away: every second step, and the count of steps is theirs."""
    assert [going(beside(6.5, **place), steps=steps)[0] for steps in range(4)] == [0, 1, 0, 1]
    assert int(going(beside(6.5, **place), steps=3)[1].steps[0, 0]) == 4


def test_they_stand_at_the_edge_until_the_car_has_passed():
    at_edge = [going(beside(ahead, left=1.25), steps=1)[0] for ahead in (4.5, 0.0, -2.4, -2.6)]
    assert at_edge == [0, 0, 0, 1]
    assert going(beside(6.5, left=1.25), steps=1)[0] == 1, "the front is 1.6 s away"


@pytest.mark.parametrize(
    "seen",
    [
        {"ahead": 12.0}, {"ahead": 6.5, "left": 3.0}, {"ahead": 6.5, "left": 1.0}, {"ahead": 6.5, "aside": 1.0},
        {"ahead": 6.5, "speed": 0.4}, {"ahead": 6.5, "to_kerb": 1.0},
    ],
    ids=["far", "not there yet", "in the path", "away from it", "a standing car", "on the sidewalk"],
)  # fmt: skip
def test_otherwise_they_go(seen):
    assert going(beside(**seen))[0] == 1


def test_they_have_a_name():
    assert POPULATIONS["campus"]() == CAMPUS
