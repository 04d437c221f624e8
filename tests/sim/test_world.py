"""The rules of a world: written as plain numbers, used as arrays."""

from __future__ import annotations

import dataclasses
from collections import Counter

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import SimConfig, Street
from jaxwalk.sim import pedestrian, vehicle
from sim.play import compiled

OTHER = SimConfig(
    slowest_walk=0.8, fastest_walk=1.9, wheelbase=2.7, max_speed=13.9, max_steering=0.6, max_acceleration=7.0,
    offroad_margin=0.4, offroad_speed=0.2, collision_distance=1.1, goal_distance=4.0, moving_speed=0.3,
    start_clearance=12.0, goal_spacing=25.0, kerb_distance=2.0, jaywalk_multiplier=0.7,
)  # fmt: skip
"""Every rule but the static ones is another."""


@pytest.fixture(scope="module")
def other():
    return Street.create(config=OTHER)


def test_plain_numbers_come_back_as_they_were_written(street, other):
    assert street.config == SimConfig()
    assert other.config == OTHER
    assert repr(other.config.max_speed) == "13.9"


def test_other_rules_compile_nothing_anew(street):
    """One trace of a step serves every rule that changes no shape."""
    keeps_the_shapes = dataclasses.replace(OTHER, fastest_walk=2.0, goal_spacing=20.0, start_clearance=10.0)
    traces = Counter()

    def step(world, scenario, car, people):
        traces["step"] += 1
        go = jnp.ones(people.going.shape, bool)
        return vehicle.drive(world, scenario, car, jnp.ones(2)), pedestrian.walk(world, scenario, people, go)

    @jax.jit
    def start(street, world):
        scenario = street.draw(jax.random.key(0))
        return scenario, vehicle.place(world, scenario), pedestrian.place(world, scenario)

    one_step, velocity = jax.jit(step), compiled(pedestrian.velocity)
    speeds, strides = [], []
    for config in (SimConfig(), keeps_the_shapes):
        world = street.world if config == SimConfig() else Street.create(config=config).world
        scenario, car, people = start(street, world)
        for _ in range(3):
            car, people = one_step(world, scenario, car, people)
        speeds.append(float(car.speed))
        strides.append(np.max(velocity(world, scenario, people)))
    assert traces["step"] == 1
    assert speeds == pytest.approx([3 * 0.1 * 3.0, 3 * 0.1 * 7.0])
    assert strides[0] != strides[1]


def test_the_whole_street_has_one_structure(street, other):
    """So no function that takes a street is traced again for other rules, unless a scenario's tables grow."""
    same_tables = dataclasses.replace(other.world, goals=street.world.goals, crossings=street.world.crossings)
    shapes = jax.tree.map(lambda x: (x.shape, x.dtype), dataclasses.replace(other, world=same_tables).world.rules)
    assert shapes == jax.tree.map(lambda x: (x.shape, x.dtype), street.world.rules)
    assert jax.tree.structure(same_tables) == jax.tree.structure(street.world)


def test_an_impossible_multiplier_is_refused():
    for multiplier in (-0.1, float("inf"), float("nan")):
        with pytest.raises(ValueError, match="jaywalk_multiplier must be a finite number of 0 or more"):
            Street.create(jaywalk_multiplier=multiplier)


def test_a_margin_that_no_road_has_is_refused():
    """The paper's roads are 8 m wide; a car put back 5 m from one edge would be off the road at the other."""
    assert Street.create(config=SimConfig(offroad_margin=4.0)).config.offroad_margin == 4
    with pytest.raises(ValueError, match="offroad_margin must be at most half the narrowest road's width, 4 m, not 5"):
        Street.create(config=SimConfig(offroad_margin=5.0))
