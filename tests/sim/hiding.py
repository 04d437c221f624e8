"""A street where vehicles and buildings hide people, with its scenarios and states."""

from __future__ import annotations

from functools import cache

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk import Street
from jaxwalk.interfaces import Moment
from jaxwalk.sim.observation import X_RAY, Observation
from jaxwalk.sim.sim_config import SimConfig
from sim import passersby

RULES = SimConfig(horizon=100, pedestrians=12, parked=0.6, perception=True, contact="footprint")
STREET, BATCH, STEPS = "validation-1000000003", 32, 60


@cache
def hiding_street():
    return Street.create([STREET], RULES, jaywalk_multiplier=1.0)


def drawn(street):
    return passersby.drawn(street, BATCH)


@eqx.filter_jit
def drive(street, scenarios, steps=STEPS):
    """The state after some steps of a slow car among people who go."""
    actions = {"driver": jnp.stack([jnp.full(BATCH, 0.2), jnp.zeros(BATCH)])}
    actions["pedestrian"] = jnp.ones((street.world.rules.pedestrians, BATCH), int)

    def step(state, _):
        state, _ = street.step(scenarios, state, actions)
        people = state.pedestrian
        columns = (people.x, people.y, people.on_roadway, people.crossing, people.decisions)
        return state, (state.perceived, *columns)

    return jax.lax.scan(step, street.reset(scenarios), None, steps)


@eqx.filter_jit
def play_on(street, scenarios):
    """The state after the same steps, without looking: it also works where nobody is hidden."""
    actions = {"driver": jnp.stack([jnp.full(BATCH, 0.2), jnp.zeros(BATCH)])}
    actions["pedestrian"] = jnp.ones((12, BATCH), int)
    return jax.lax.scan(
        lambda s, _: (street.step(scenarios, s, actions)[0], None), street.reset(scenarios), None, STEPS
    )


@eqx.filter_jit
def look(street, scenarios, state, name, role="driver"):
    """What somebody sees, by the name of the set."""
    return Observation(role, name)(Moment(street.world, scenarios, state))


def x_ray(street, scenarios, state):
    """What a car sees that looks through everything."""
    return np.asarray(look(street, scenarios, state, X_RAY))
