"""The set that is told who has decided to jaywalk: before anybody steps out, it names the place where they will."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk import Street
from jaxwalk.interfaces import Moment
from jaxwalk.sim.crossing_kind import JAYWALK, LegKind
from jaxwalk.sim.observation import DECIDED, Observation, part
from jaxwalk.sim.prediction import DISTANCE, NEIGHBOURS
from jaxwalk.sim.sim_config import SimConfig

PEOPLE, BATCH, STEPS = NEIGHBOURS, 32, 200


@eqx.filter_jit
def watch(street, scenarios):
    """Kinds of leg, decisions and places of everybody in each step, and what the standing car is told."""
    actions = {"driver": jnp.zeros((2, BATCH)), "pedestrian": jnp.ones((PEOPLE, BATCH), int)}

    def step(state, _):
        car, people = state.vehicle, state.pedestrian
        told = Observation("driver", DECIDED)(Moment(street.world, scenarios, state))
        told = told[part("driver", DECIDED, "decisions")].reshape(NEIGHBOURS, 3, BATCH)
        order = jnp.argsort(state.foresight.people.ahead**2 + state.foresight.people.left**2, axis=0)
        ahead, left = told[:, 1] * DISTANCE, told[:, 2] * DISTANCE
        place = jnp.stack([car.x + ahead * car.cos - left * car.sin, car.y + ahead * car.sin + left * car.cos])
        people_now = (people.leg.kind, people.crossing, jnp.stack([people.x, people.y]))
        return street.step(scenarios, state, actions)[0], (people_now, order, told[:, 0], place)

    return jax.lax.scan(step, street.reset(scenarios), None, STEPS)[1]


def test_who_is_told_to_jaywalk_steps_out_there():
    street = Street.create(config=SimConfig(pedestrians=PEOPLE, jaywalk_multiplier=1.0, horizon=STEPS))
    scenarios = jax.vmap(street.draw, out_axes=-1)(jax.random.split(jax.random.key(77), BATCH))
    (kind, crossing, at), order, told, place = jax.tree.map(np.asarray, watch(street, scenarios))
    np.testing.assert_array_equal(told, np.take_along_axis(crossing, order, axis=1) == JAYWALK)

    rank = np.argsort(order, axis=1)
    foretold = np.take_along_axis(place, rank[:, None], axis=2)
    steps_out = (kind[1:] == LegKind.ACROSS) & (kind[:-1] == LegKind.TO_ZONE)
    assert steps_out.sum() > 20
    errors = []
    for step, person, env in np.argwhere(steps_out):
        before = np.flatnonzero(crossing[: step + 1, person, env] != JAYWALK)
        first = before[-1] + 1 if len(before) else 0
        errors.append(np.abs(foretold[first, :, person, env] - at[step + 1, :, person, env]).max())
    assert np.max(errors) < 0.3, "a step's walk beyond the place, at most"
    across = kind == LegKind.ACROSS
    np.testing.assert_allclose(np.moveaxis(foretold, 1, -1)[across], np.moveaxis(at, 1, -1)[across], atol=1e-3)
