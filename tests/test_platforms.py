"""What is compiled for a GPU comes out as what is compiled for a CPU: both are run here, on a CPU."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.columns import apply_where
from jaxwalk.learning.networks import make_mlp
from jaxwalk.platforms import few_launches, traced_for
from jaxwalk.rollout import TRAINING, draw_batch, environment_keys, rollout, seed_key, start
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.sim.vehicle import CLOSE, onto_road

PEOPLE = 4


def test_a_cpu_is_the_only_device_without_launches():
    assert not few_launches()
    with traced_for("gpu"):
        assert few_launches()
        with traced_for("cpu"):
            assert not few_launches()
        assert few_launches()
    assert not few_launches()


def _drive_about(key, scenario, state, memory):
    """Go at full throttle with any steering; everybody walks."""
    steering = (jax.random.key_data(key)[..., 0] & 0xFFFF).astype(jnp.float32) * 2.0**-15 - 1
    go = jnp.ones((PEOPLE, *key.shape), jnp.int32)
    return {"driver": jnp.stack([jnp.ones_like(steering), steering]), "pedestrian": go}, memory, state.vehicle.x


def _played(street):
    stream, steps = rollout(street, _drive_about, start(street, environment_keys(seed_key(3, TRAINING), 0, 4)), 24)
    people = stream.state.pedestrian
    people = replace(people, following=people.leg, planned=people.going)  # what comes next is kept on a CPU alone
    return stream.scenario, replace(stream.state, pedestrian=people), stream.episode, steps


@pytest.mark.long
def test_episodes_are_the_same():
    street, found = Street.create(config=replace(WORLDS["paper-footprint"], pedestrians=PEOPLE, horizon=10)), []
    for platform in ("cpu", "gpu"):
        with traced_for(platform):
            program = jax.jit(_played)
            assert ("cond[" in str(program.trace(street).jaxpr)) is (platform == "cpu")
            found.append(jax.tree.map(np.asarray, program(street)))
    one, other = found
    assert (one[2] > 0).all()  # every environment has restarted
    jax.tree.map(lambda x, y: np.testing.assert_allclose(x, y, rtol=1e-4, atol=1e-4), one, other)


@partial(jax.jit, static_argnums=1)
def _parked(street, count):
    """Scenarios, and the car at the beginning of each."""
    scenarios = draw_batch(street, environment_keys(seed_key(1, TRAINING), 0, count))
    return scenarios, street.reset(scenarios).vehicle


def test_cars_are_pushed_back_to_the_same_place():
    street = Street.create()
    scenarios, car = _parked(street, 64)
    at = jax.device_get(car)
    aside = np.linspace(-8.0, 8.0, 64, dtype=np.float32)
    x, y = at.x - aside * at.sin, at.y + aside * at.cos

    def push(x, y):
        return onto_road(street.world, scenarios, car, x, y)

    found = []
    for platform in ("cpu", "gpu"):
        with traced_for(platform):
            found.append(jax.device_get(jax.jit(push)(x, y)))
    one, other = found
    assert 0 < one[2].sum() < 64
    assert np.hypot(one[0] - other[0], one[1] - other[1]).max() <= CLOSE
    np.testing.assert_array_equal(one[2], other[2])


def test_where_a_car_is_pushed_depends_on_no_other_car():
    street, count = Street.create(), 256
    scenarios, car = _parked(street, count)
    push = jax.jit(lambda x, y: onto_road(street.world, scenarios, car, x, y))
    ahead, aside = np.random.default_rng(1).uniform([[0], [-6]], [[60], [6]], (2, count)).astype(np.float32)
    at = jax.device_get(car)
    x, y = at.x + ahead * at.cos - aside * at.sin, at.y + ahead * at.sin + aside * at.cos
    beside = jax.device_get(push(x, y))
    off = np.flatnonzero(beside[2])
    assert 20 < len(off) < count
    for one in off:
        only = np.arange(count) == one
        alone = jax.device_get(push(np.where(only, x, at.x), np.where(only, y, at.y)))
        np.testing.assert_array_equal([found[one] for found in alone], [found[one] for found in beside])


def test_a_function_is_computed_where_it_is_asked_for():
    network = eqx.filter_jit(make_mlp)(jax.random.key(0), (3, 4, 2), final_scale=1.0)
    columns, which = jax.random.normal(jax.random.key(1), (3, 5, 40)), np.arange(200).reshape(5, 40) % 7 == 0

    def apply(network, columns, which):
        return apply_where(network, columns, which, 16)

    found = []
    for platform in ("cpu", "gpu"):
        with traced_for(platform):
            found.append(jax.device_get(jax.jit(apply)(network, columns, which)))
    np.testing.assert_allclose(*found, rtol=1e-5, atol=1e-6)
    assert (found[0][:, ~which] == 0).all()
    assert (found[0][:, which] != 0).any()
