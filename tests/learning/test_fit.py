from __future__ import annotations

from functools import cache, partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jax.flatten_util import ravel_pytree

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.learning.fit import (
    Chunks,
    Fit,
    descend,
    fit,
    learning_rate,
    map_chunks,
    mean_gradient,
    optimiser,
    pack_weighted,
    plan_chunks,
)
from jaxwalk.learning.hyperparameters import hyperparameters
from jaxwalk.learning.losses import Actions, actor_loss
from learning.games import ROLES

STEPS, ENVS = 8, 6
LOSS = partial(actor_loss, clip=0.2, entropy=0.1)
compiled_fit, compiled_gradient = eqx.filter_jit(fit), eqx.filter_jit(mean_gradient)


@cache
@eqx.filter_jit
def rollout_of(agents, action):
    actor = make_actor(jax.random.key(0), 5, action, RoleConfig(actor_hidden=(16,)))
    keys = jax.random.split(jax.random.key(1), 5)
    seen = jax.random.normal(keys[0], (STEPS, 5, *agents, ENVS))
    raw = jax.vmap(lambda x: actor(x).sample(jax.random.split(keys[1], ENVS)))(seen)
    log_prob = jax.vmap(lambda x, u: actor(x).log_prob(u))(seen, raw)
    old = log_prob + 0.3 * jax.random.normal(keys[2], log_prob.shape)
    advantage = jax.random.normal(keys[3], log_prob.shape)
    weight = jax.random.bernoulli(keys[4], 0.7, (STEPS, ENVS)).astype(jnp.float32)
    return actor, Actions(seen, raw, old, advantage, weight)


@eqx.filter_jit
def loss_and_gradient(actor, data, times):
    """Over the whole minibatch at once, with its axes left where they are."""

    def plainly(actor):
        part = jax.tree.map(lambda x: jnp.moveaxis(x[times], 0, -2), data)
        total, sums = LOSS(actor, part)
        return total / sums["weight"]

    value, slopes = jax.value_and_grad(plainly)(actor)
    return value, ravel_pytree(slopes)[0]


@pytest.mark.parametrize(("agents", "action"), [((), Box(2)), ((3,), Discrete(2))])
@pytest.mark.parametrize("chunks", [Chunks(1, 3), Chunks(4, 2)])
def test_chunked_gradient_is_that_of_the_whole(agents, action, chunks):
    actor, data = rollout_of(agents, action)
    times = np.array([5, 0, 7, 2], np.int32)
    gradient, report = compiled_gradient(LOSS, actor, data, times, chunks=chunks)
    value, expected = loss_and_gradient(actor, data, times)
    assert float(report["policy_loss"]) - 0.1 * float(report["entropy"]) == pytest.approx(float(value), rel=1e-5)
    np.testing.assert_allclose(gradient, expected, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("columns", [6, 18])
def test_entries_with_weight_give_the_gradient_of_all(columns):
    actor, data = rollout_of((3,), Discrete(2))
    weight = np.zeros((STEPS, 3, ENVS), np.float32)
    weight[2, 1] = weight[5, :, 2] = 1
    data = Actions(data.observation, data.raw, data.log_prob, data.advantage, jax.device_put(weight))
    few = jax.jit(pack_weighted, static_argnames="columns")(data, columns=columns)
    assert few.observation.shape == (STEPS, 5, columns)
    assert np.asarray(few.weight).sum() == weight.sum() == 9
    times = np.arange(STEPS, dtype=np.int32)
    want, _ = compiled_gradient(LOSS, actor, data, times, chunks=Chunks(1, 1))
    got, _ = compiled_gradient(LOSS, actor, few, times, chunks=Chunks(1, 1))
    np.testing.assert_allclose(got, want, rtol=1e-4, atol=1e-6)


@given(st.integers(1, 24), st.integers(1, 48), st.integers(1, 32), st.integers(1, 5000))
def test_plans_divide_evenly_and_keep_to_the_rows(agents, environments, steps, rows):
    plan = plan_chunks(agents=agents, environments=environments, steps=steps, rows=rows)
    assert steps % plan.steps == 0
    assert environments % plan.parts == 0
    assert plan.steps == 1 or plan.parts == 1
    assert agents * environments * plan.steps // plan.parts <= max(rows, agents)


def test_plans_of_the_papers_sizes():
    assert plan_chunks(agents=1, environments=512, steps=32, rows=2048) == Chunks(4, 1)
    assert plan_chunks(agents=12, environments=512, steps=32, rows=2048) == Chunks(1, 4)
    assert plan_chunks(agents=12, environments=512, steps=32, rows=10**9) == Chunks(32, 1)


@pytest.mark.parametrize("chunks", [Chunks(2, 1), Chunks(1, 3), Chunks(8, 2)])
def test_mapping_over_chunks_keeps_every_entry_in_its_place(chunks):
    data = np.arange(STEPS * 2 * 3 * ENVS, dtype=np.float32).reshape(STEPS, 2, 3, ENVS)
    mapped = jax.jit(lambda data: map_chunks(lambda x: x[0] - x[1], data, chunks=chunks))(data)
    np.testing.assert_array_equal(mapped, data[:, 0] - data[:, 1])


@eqx.filter_jit
def memory_of(network, config):
    """The optimiser's before the first step."""
    return optimiser(hyperparameters(config)).init(network)


def test_every_epoch_sees_every_step_once_in_its_own_order():
    config = TrainConfig(ROLES, steps=STEPS, environments=ENVS, minibatches=4)
    seen = []

    def loss(network, chunk):
        jax.debug.callback(lambda t: seen.append(np.asarray(t)[:, 0].astype(int).tolist()), chunk, ordered=True)
        return network * jnp.sum(chunk), {"weight": jnp.float32(chunk.size)}

    times = np.broadcast_to(np.arange(STEPS, dtype=np.float32)[:, None], (STEPS, ENVS))
    network = jax.device_put(np.float32(1))
    out = compiled_fit(
        Fit(config, hyperparameters(config), np.float32(0.1), epochs=2, agents=1, environments=ENVS), loss, network,
        memory_of(network, config), times, jax.random.key(0),
    )  # fmt: skip
    jax.block_until_ready(out)
    jax.effects_barrier()
    order = [time for chunk in seen for time in chunk]
    assert sorted(order[:STEPS]) == sorted(order[STEPS:]) == list(range(STEPS))
    assert order[:STEPS] != order[STEPS:]


def test_every_parameter_goes_against_its_own_gradient():
    config = TrainConfig(ROLES, steps=STEPS, environments=ENVS, minibatches=1, adam_epsilon=1e-12)
    signs = {"a": np.float32([[1, -1, 1], [-1, -1, 1]]), "b": np.float32([-1, 1])}
    network = jax.device_put(jax.tree.map(np.zeros_like, signs))

    def loss(network, chunk):
        slope = sum(jnp.sum(signs[name] * network[name]) for name in signs)
        return slope * chunk.size, {"weight": jnp.float32(chunk.size)}

    moved, memory, report = compiled_fit(
        Fit(config, hyperparameters(config), np.float32(0.1), epochs=1, agents=1, environments=ENVS), loss, network,
        memory_of(network, config), np.zeros((STEPS, ENVS), np.float32), jax.random.key(0),
    )  # fmt: skip
    assert {x.shape for x in jax.tree.leaves(memory)} == {(), (8,)}
    assert float(report["gradient_norm"]) == pytest.approx(8**0.5)
    jax.tree.map(lambda x, sign: np.testing.assert_allclose(x, -0.1 * sign, rtol=1e-5), moved, signs)


def test_annealing():
    begin, planned, rate = np.float32(0.5), np.int32(10), jax.jit(learning_rate, static_argnames="anneal")
    falling = [float(rate(begin, np.int32(n), planned, anneal=True)) for n in (0, 5, 10, 11)]
    assert falling == [0.5, 0.25, 0, 0]
    assert float(rate(begin, np.int32(9999), planned, anneal=False)) == 0.5


def test_adams_first_step_has_the_size_of_the_rate_and_ignores_the_gradients_size():
    config = TrainConfig(ROLES, adam_epsilon=1e-12)
    parameters, gradient = np.float32([1, 2, 3]), np.float32([1e6, -1e6, 1e6])
    memory, step = memory_of(parameters, config), jax.jit(descend)
    moved, _ = step(parameters, memory, gradient, rate=np.float32(0.1), numbers=hyperparameters(config))
    np.testing.assert_allclose(moved, [0.9, 2.1, 2.9], rtol=1e-5)
