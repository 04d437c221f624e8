"""Nobody hidden reaches any view, but for those that no real car could have, nor any rule: not by a memory either."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.interfaces import Moment
from jaxwalk.policies import DRIVERS, SHIELDS, shielded
from jaxwalk.policies.belief_planner import BeliefPlanner
from jaxwalk.policies.people_futures import PeopleBelief
from jaxwalk.sim.observation import OBSERVATIONS, PRIVILEGED_SETS, Observation
from jaxwalk.sim.perception import first_perceived, perceive
from jaxwalk.sim.sim_config import WORLDS

PEOPLE, BATCH, STEPS, AWAY = 24, 16, 25, 25.0
WORLD = replace(WORLDS["blind-corner"], pedestrians=PEOPLE, horizon=STEPS)
VIEWS = [name for name in OBSERVATIONS["driver"] if name not in PRIVILEGED_SETS]
SAME = ("belief-planner-chance", "belief-planner-cvar")
"""Drivers that see and foresee what another one does, and take long to compile."""
RULES = {name: make() for name, make in DRIVERS.items() if name not in SAME}
RULE_BASED = {name: driver for name, driver in RULES.items() if driver.view.name not in PRIVILEGED_SETS}
RULE_BASED["belief-planner"] = BeliefPlanner(PeopleBelief(futures=2, hazard=0.1, emergence=0.1))
SHIELDED = {name: shielded(DRIVERS["route-follower"](), name) for name in SHIELDS}
PERFECT = {}
DIALS = {"delay": 0.2, "position_noise": 0.1, "misses": 0.2}


@eqx.filter_jit
def drive(street, scenarios):
    """Cars and people of each step, from the start on."""
    actions = {"driver": jnp.stack([jnp.full(BATCH, 0.3), jnp.zeros(BATCH)])}
    actions["pedestrian"] = jnp.ones((PEOPLE, BATCH), int)

    def step(state, _):
        return street.step(scenarios, state, actions)[0], (state.vehicle, state.pedestrian)

    return jax.lax.scan(step, street.reset(scenarios), None, STEPS)[1]


@eqx.filter_jit
def watch(street, scenarios, cars, people):
    """All that drivers know, see and do while cars and people are where these frames have them, as a step finds it."""

    def step(before, frame):
        knows, memories = before
        number, car, crowd = frame
        knows = perceive(street.world, scenarios, jnp.full(BATCH, number), car, crowd, knows)
        state = street._state(scenarios, jnp.full(BATCH, number), car, crowd, knows)
        moment = Moment(street.world, scenarios, state)
        seen = {name: Observation("driver", name)(moment) for name in VIEWS}
        does = {}
        for name, rule in RULE_BASED.items():
            key = jax.random.split(jax.random.fold_in(jax.random.key(77), number), BATCH)
            does[name], memories[name] = rule.act(key, memories[name], rule.view(moment))
        for name, rule in SHIELDED.items():
            does[name], *_ = rule.decide(key, None, rule.view(moment))
        return (knows, memories), (knows, seen, does)

    first = jax.tree.map(lambda x: x[0], (cars, people))
    memories = {name: rule.init((), (BATCH,)) for name, rule in RULE_BASED.items()}
    begin = first_perceived(street.world, scenarios, *first), memories
    frames = (jnp.arange(1, STEPS), *jax.tree.map(lambda x: x[1:], (cars, people)))
    return begin[0], jax.lax.scan(step, begin, frames)[1]


def elsewhere(people, random):
    """Everybody somewhere else up to `AWAY`, on other legs, with other plans."""

    def anothers(values):
        values = np.asarray(values)
        other = random.permuted(values, axis=-1) + (random.random(values.shape) < 0.5).astype(values.dtype)
        return jnp.asarray(other)

    shaken = jax.tree.map(anothers, people)
    angle = random.uniform(-np.pi, np.pi, people.x.shape)
    x, y = (np.asarray(at) + random.uniform(-AWAY, AWAY, angle.shape) for at in (people.x, people.y))
    cos, sin = np.cos(angle), np.sin(angle)
    ends = {"cos": cos, "sin": sin, "end_x": x + cos * shaken.remaining, "end_y": y + sin * shaken.remaining}
    leg = replace(shaken.leg, **{name: jnp.asarray(value, jnp.float32) for name, value in ends.items()})
    return replace(shaken, leg=leg)


def where(chosen, one, other):
    return jax.tree.map(lambda a, b: jnp.where(chosen, a, b).astype(b.dtype), one, other)


def sight_of(watched):
    first, (knows, *_) = watched
    return np.concatenate([np.asarray(first.in_sight)[None], np.asarray(knows.in_sight)])


@pytest.mark.long
@pytest.mark.parametrize("dials", [PERFECT, DIALS], ids=["perfect", "dials"])
def test_whatever_hidden_people_do_no_driver_notices(dials):
    """Whoever is out of sight is elsewhere, still out of sight, in every step: what cars know, see and do is the same.

    Bit for bit, with the beliefs, ages and last seen places that go from step to step.
    """
    street = Street.create(["validation-1000000003"], replace(WORLD, **dials), jaywalk_multiplier=2.0)
    scenarios = jax.vmap(street.draw, out_axes=-1)(jax.random.split(jax.random.key(77), BATCH))
    cars, people = drive(street, scenarios)
    as_it_was = watch(street, scenarios, cars, people)
    hidden = ~sight_of(as_it_was)
    assert 0.1 < hidden.mean() < 0.98  # some are seen
    for seed in range(2):
        moved = where(hidden, elsewhere(people, np.random.default_rng(seed)), people)
        still = hidden & ~sight_of(watch(street, scenarios, cars, moved))
        assert still.sum() > hidden.sum() / 10
        moved = where(still, moved, people)
        again = watch(street, scenarios, cars, moved)
        for (path, before), after in zip(
            jax.tree_util.tree_leaves_with_path(as_it_was), jax.tree.leaves(again), strict=True
        ):
            np.testing.assert_array_equal(before, after, err_msg=jax.tree_util.keystr(path))
