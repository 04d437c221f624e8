from __future__ import annotations

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning import actor as actors
from jaxwalk.learning import networks
from jaxwalk.learning.config import RoleConfig
from jaxwalk.learning.networks import MLP
from pytrees import floats

make_actor, make_mlp, orthogonal = map(eqx.filter_jit, (actors.make_actor, networks.make_mlp, networks.orthogonal))
applied = eqx.filter_jit(lambda network, seen: network(seen))
normal = jax.jit(lambda seed, shape: jax.random.normal(jax.random.key(seed), shape), static_argnums=(0, 1))


def test_by_hand():
    network = MLP((floats([1, -1], [2, 0]), floats([1, 1])), (floats(0, -1), floats(1)))
    # hidden: relu(1 - 3) = 0, relu(2 - 1) = 1; out: 0 + 1 + 1
    assert applied(network, floats(1, 3)).tolist() == [2]
    assert network.sizes == (2, 2, 1)


@pytest.mark.parametrize("rest", [(), (5,), (12, 5), (12, 2, 5)])
def test_columns_do_not_know_of_each_other(rest):
    network = make_mlp(jax.random.key(0), (4, 8, 3), final_scale=1.0)
    x = np.asarray(normal(1, (4, *rest)))
    alone = np.stack([applied(network, column) for column in x.reshape(4, -1).T], axis=-1)
    np.testing.assert_allclose(applied(network, x), alone.reshape(3, *rest), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("shape", [(3, 8), (8, 3), (5, 5)])
def test_orthogonal(shape):
    q = np.asarray(orthogonal(normal(0, shape)))
    short = q @ q.T if shape[0] <= shape[1] else q.T @ q
    np.testing.assert_allclose(short, np.eye(min(shape)), atol=1e-5)


def test_layers_differ_and_start_at_their_scales():
    network = make_mlp(jax.random.key(0), (8, 8, 8, 2), final_scale=0.01)
    norms = [np.linalg.norm(weight, 2) for weight in network.weights]
    np.testing.assert_allclose(norms, [2**0.5, 2**0.5, 0.01], rtol=1e-4)
    assert not np.allclose(network.weights[0], network.weights[1], equal_nan=True)


@pytest.mark.parametrize(("action", "kind"), [(Discrete(3), "discrete"), (Box(2), "tanh"), (Box(2), "clipped")])
def test_actor_starts_nearly_indifferent(action, kind):
    actor = make_actor(jax.random.key(0), 4, action, RoleConfig(noise="tanh" if kind == "tanh" else "clipped"))
    choice = applied(actor, normal(1, (4, 100)))
    assert actor.kind == kind
    spread = choice.logits if kind == "discrete" else choice.mean
    assert np.abs(spread).max() < 0.1


def test_a_clipped_actors_mean_stays_inside():
    actor = make_actor(jax.random.key(0), 4, Box(2), RoleConfig())
    seen = np.float32(1e6) * np.asarray(normal(1, (4, 100)))
    assert np.abs(applied(actor, seen).mean).max() <= 1
