"""A gated actor that looks only where there is something to decide says the same as one that looks everywhere."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.actor import GLANCE_PART, glance, make_actor
from jaxwalk.learning.config import RoleConfig
from jaxwalk.rollout import environment_keys

AGENTS, BATCH = 12, 16
GATED = make_actor(jax.random.key(0), 5, Discrete(2), RoleConfig(gated=True, actor_hidden=(8,)))


def observations(deciding):
    """Random ones, (feature, agent, batch), of which so many have something to decide."""
    random = np.random.default_rng(deciding)
    seen = random.normal(size=(5, AGENTS * BATCH)).astype(np.float32)
    seen[0] = 0
    seen[0, random.choice(AGENTS * BATCH, deciding, replace=False)] = 1
    return jnp.asarray(seen.reshape(5, AGENTS, BATCH))


@pytest.mark.parametrize("deciding", [0, 1, AGENTS * BATCH // GLANCE_PART, AGENTS * BATCH // GLANCE_PART + 1, 100, 192])
def test_a_glance_sees_everybody_who_decides(deciding):
    seen = observations(deciding)
    quick, full = jax.jit(glance)(GATED, seen), GATED(seen)
    np.testing.assert_array_equal(quick.decides, full.decides)
    assert int(quick.decides.sum()) == deciding
    where = np.asarray(full.decides)
    np.testing.assert_allclose(
        np.asarray(quick.choice.logits)[:, where], np.asarray(full.choice.logits)[:, where], atol=1e-7
    )


def test_what_is_sampled_and_how_likely_it_was_are_the_same():
    seen, keys = observations(60), environment_keys(jax.random.key(1), 0, BATCH)
    quick, full = glance(GATED, seen), GATED(seen)
    raw = full.sample(keys)
    np.testing.assert_array_equal(quick.sample(keys), raw)
    np.testing.assert_allclose(quick.log_prob(raw), full.log_prob(raw), atol=1e-6)
    assert 0 < int(raw.sum()) < raw.size


def test_other_kinds_look_everywhere():
    actor = make_actor(jax.random.key(0), 5, Box(2), RoleConfig(actor_hidden=(8,)))
    seen = observations(3)[:, 0]
    np.testing.assert_array_equal(glance(actor, seen).mean, actor(seen).mean)
