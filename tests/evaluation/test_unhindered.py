"""What delays are measured against is what the simulator plays if nobody can be touched."""

from __future__ import annotations

import equinox as eqx
import numpy as np
import pytest

from jaxwalk.evaluation import evaluate
from jaxwalk.evaluation.unhindered import unhindered_times
from jaxwalk.metrics import DELAY, OUTCOMES, summarise
from jaxwalk.runs.contestants import contestant
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import SimConfig


@pytest.fixture(scope="module")
def untouchable(street):
    return eqx.tree_at(lambda s: s.world.rules.collision_distance, street, street.world.rules.collision_distance / 1000)


def test_the_simulator_takes_the_same_time_where_nobody_can_be_touched(untouchable, driver, undecided):
    rows = evaluate(untouchable, {"driver": driver, "pedestrian": undecided}, Drawn(untouchable, 7, 40), batch=16)
    assert rows[OUTCOMES].goal.all()
    np.testing.assert_allclose(rows[OUTCOMES].steps * rows.dt, rows[DELAY].time)
    found = summarise(rows)[DELAY]
    assert (found.mean.value, found.long.value) == pytest.approx((0, 0), abs=1e-6)
    assert found.mean.count == 40


def test_people_cost_a_blind_car_no_time(rows, street):
    """It arrives at the unhindered time or not at all."""
    arrived = rows[OUTCOMES].goal
    assert 0 < arrived.sum() < 40
    np.testing.assert_allclose(rows[OUTCOMES].steps[arrived] * rows.dt, rows[DELAY].time[arrived])
    assert summarise(rows)[DELAY].mean.count == arrived.sum()


def test_a_car_that_never_arrives_has_no_time(street):
    times = unhindered_times(Street.create(config=SimConfig(horizon=60)))
    assert np.isnan(times).any() and np.nanmax(times) <= 6
    assert not np.isnan(unhindered_times(street)).any()


def test_another_car_steers_by_its_own_axles():
    """A long car that turns its wheels little takes other times, and the same as the rule by name does there."""
    config = SimConfig(wheelbase=4.5, max_steering=0.3, collision_distance=0.001)
    long = Street.create(config=config)
    policies = {
        role: contestant(long, role, name) for role, name in (("driver", "route-follower"), ("pedestrian", "always-go"))
    }
    rows = evaluate(long, policies, Drawn(long, 7, 16), batch=16)
    arrived = rows[OUTCOMES].goal
    assert arrived.sum() > 10
    np.testing.assert_allclose(rows[OUTCOMES].steps[arrived] * rows.dt, rows[DELAY].time[arrived])
    usual = unhindered_times(Street.create())
    assert not np.array_equal(unhindered_times(long), usual, equal_nan=True)
