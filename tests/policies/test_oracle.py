"""The driver that knows the future, in situations made by hand and among always-go."""

from __future__ import annotations

import json
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.cli import main
from jaxwalk.evaluation import evaluate
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo, Oracle, RouteFollower
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.future import MOMENTS, PLACES, SPACING, STEPS
from jaxwalk.sim.manoeuvres import FAR
from jaxwalk.sim.observation import PRIVILEGED, part, size
from jaxwalk.sim.prediction import DISTANCE
from jaxwalk.sim.sim_config import WORLDS
from sim.play import AS_SHIPPED

SIZE = size("driver", PRIVILEGED)
LENGTH = 90.0
STEPS_PLAYED = 400
CASES = 41
KEYS = jax.random.split(jax.random.key(0), CASES)


def apart(contact, person, along):
    """The distance by this contact of a person's centre to a car at a place of the lane [m]."""
    ahead, left = person[0] - along, person[1]
    if contact == "disc":
        return jnp.hypot(ahead, left)
    return jnp.hypot(jnp.maximum(jnp.abs(ahead) - 2.25, 0), jnp.maximum(jnp.abs(left) - 0.9, 0))


def observation(contact, along, speed, person, limit):
    """On a straight road of 90 m; ``person`` is (ahead of the start, left of the lane) [m], each (moment, case)."""
    places = along + SPACING * jnp.arange(PLACES)[:, None]
    away = apart(contact, [x[:, None] for x in person], places)
    seen = jnp.zeros((SIZE, CASES))
    for name, value in (("speed", speed / SPEED), ("to_go", (LENGTH - along) / DISTANCE), ("heading", [[1.0], [0.0]])):
        seen = seen.at[part("driver", PRIVILEGED, name)].set(value)
    seen = seen.at[part("driver", PRIVILEGED, "route")].set(jnp.tile(jnp.array([1.0, 0.0]), 8)[:, None])
    seen = seen.at[part("driver", PRIVILEGED, "limits")].set(limit / SPEED)
    table = jnp.minimum(away, FAR) / FAR
    return seen.at[part("driver", PRIVILEGED, "clearances")].set(table.reshape(-1, CASES))


def drive(driver, person, limit=8.33):
    """(along, speed, distance to the person), each (step, case), from a standing start, with a speed limit.

    ``person(time)`` is (ahead of the start, left of the lane) [m], ``(..., case)``.
    """
    steps = np.arange(STEPS_PLAYED + STEPS * MOMENTS + 1)[:, None]
    walked = [np.broadcast_to(x, (len(steps), CASES)).astype(np.float32) for x in person(0.1 * steps)]
    *played, steering = map(np.asarray, _drive(driver, walked, np.float32(limit)))
    assert (steering == 0).all()
    return played


@partial(jax.jit, static_argnames="driver", compiler_options=AS_SHIPPED)
def _drive(driver, walked, limit):
    """Who walks, and the limit, are arguments, so that a program for each driver serves all tests."""
    moments = STEPS * jnp.arange(1, MOMENTS + 1)

    def body(car, step):
        along, speed, memory = car
        person = [x[step + moments] for x in walked]
        action, memory = driver.act(KEYS, memory, observation(driver.contact, along, speed, person, limit))
        largest = jnp.where(action[0] < 0, driver.max_braking, driver.max_acceleration)
        speed = jnp.clip(speed + 0.1 * largest * action[0], 0, limit)
        along = along + 0.1 * speed
        away = apart(driver.contact, [x[step + 1] for x in walked], along)
        return (along, speed, memory), (along, speed, away, action[1])

    begin = (jnp.zeros(CASES), jnp.zeros(CASES), driver.init((), (CASES,)))
    return jax.lax.scan(body, begin, jnp.arange(STEPS_PLAYED))[1]


def under_way(along):
    return along < LENGTH - 3


def crossing(time):
    """Across the road at 30 m, at 1.5 m/s, from 3 m beside the lane or farther."""
    return np.full(CASES, 30.0), 3 + 0.25 * np.arange(CASES) - 1.5 * time


def lying(time):
    """In the middle of the lane, from 20 to 40 m."""
    return 20 + 0.5 * np.arange(CASES), 0 * time


def oncoming(time):
    """Along the lane toward the car at 1.5 m/s, then off it at 30 m: to stand still there would be no help."""
    walked = 1.5 * time
    ahead = 36 + 0.1 * np.arange(CASES) - walked
    return np.maximum(ahead, 30.0), np.maximum(30 - ahead, 0)


def standing_place(time):
    """Across the start: whoever waits there is walked into."""
    return np.zeros(CASES), 6 + 0.1 * np.arange(CASES) - 1.5 * time


@pytest.mark.parametrize("person", [crossing, oncoming, standing_place])
def test_it_gets_by_without_touching_and_arrives(person):
    along, _, away = drive(Oracle(), person)
    assert away[under_way(along)].min() > 1.8
    assert (along[-1] > LENGTH - 3).all()


def test_it_slows_down_only_for_whom_it_would_meet():
    along, speed, _ = drive(Oracle(), crossing)
    slows = (np.diff(speed, axis=0) < -1e-3).any(axis=0)
    duration = 0.1 * under_way(along).sum(axis=0)
    assert slows.any()
    assert not slows.all()
    assert duration.min() < 12.2  # 87 m from a standing start take 11.9 s
    assert duration.max() < 15.5


IN_TOWN = with_limits(Oracle(), WORLDS["town"])


@pytest.mark.parametrize(
    "limit", [13.9, pytest.param(8.33, marks=pytest.mark.long), pytest.param(5.56, marks=pytest.mark.long)]
)
def test_in_town_it_is_as_fast_as_the_limit_allows(limit):
    """Nobody is on the road; 13.33 m/s is the fastest that it plans, and levels are 1.67 m/s apart."""
    along, speed, _ = drive(IN_TOWN, lambda time: (np.full(CASES, -60.0), 0 * time), limit)
    assert limit - 1.67 < speed.max() <= limit
    assert (along[-1] > LENGTH - 3).all()


@pytest.mark.parametrize("limit", [13.9, 8.33])
def test_in_town_it_gets_by_and_brakes_as_it_plans(limit):
    along, speed, away = drive(IN_TOWN, crossing, limit)
    assert away[under_way(along)].min() > 0.55, "a body of 0.25 m, and 0.4 m for leaving the route, but for rounding"
    assert (along[-1] > LENGTH - 3).all()
    assert np.diff(speed, axis=0).min() > -0.31, "2.8 m/s2, not the 7.6 that its brakes could"


def test_by_footprint_it_stops_before_its_front_touches():
    """By the paper's disc, 1.8 m from the centre would do, which is inside the car."""
    _, speed, away = drive(IN_TOWN, lying)
    assert (speed[-1] == 0).all()
    assert away.min() > 0.55
    assert away[-1].max() < 7


def beside(time):
    """At the lane's edge, 1.6 m from its middle: 0.45 m from a car that passes."""
    return 20 + 0.5 * np.arange(CASES) + 0 * time, np.full(CASES, 1.6)


@pytest.mark.long
def test_by_footprint_it_passes_where_the_disc_would_not():
    along, _, away = drive(IN_TOWN, beside, 8.33)
    assert (along[-1] > LENGTH - 3).all()
    assert away.min() == pytest.approx(0.7), "from its side to the middle of the person"
    stays, _, _ = drive(Oracle(), beside)
    assert under_way(stays[-1]).all()


def test_it_stops_before_who_stays():
    _, speed, away = drive(Oracle(), lying)
    assert (speed[-1] == 0).all()
    assert away.min() > 1.8
    assert away[-1].max() < 7


@pytest.fixture(scope="module")
def played(street):
    """Rows of 32 scenarios among always-go."""
    return evaluate(street, {"driver": Oracle(), "pedestrian": AlwaysGo()}, Drawn(street, 3, 32), batch=16)[OUTCOMES]


@pytest.mark.long
def test_among_always_go_it_always_arrives(street, played):
    blind = evaluate(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, Drawn(street, 3, 32), batch=16)[
        OUTCOMES
    ]
    assert blind.collision.sum() > 5
    assert played.goal.all()
    both = blind.goal
    assert played.steps[both].mean() < 1.15 * blind.steps[both].mean()


@pytest.mark.long
def test_the_command_line_says_that_it_is_privileged(tmp_path, capsys):
    assert main(["evaluate", "--driver", "oracle", "--episodes", "4", "--out", str(tmp_path)]) == 0
    assert "oracle (privileged)" in capsys.readouterr().out
    cells = json.loads((tmp_path / "results.json").read_text())["cells"]
    assert [cell["driver_observes"] for cell in cells] == ["privileged"]
