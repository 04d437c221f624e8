from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import pytest

from jaxwalk.evaluation import evaluate, evaluate_grid, with_jaywalk_multiplier
from jaxwalk.policies import AlwaysGo, Random, RouteFollower
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.observation import Observation

BATCH = 16  # everywhere, so that little is compiled


class Undecided(eqx.Module):
    """Pedestrians who toss a coin at every step, and remember how often."""

    view: Observation = eqx.field(static=True, default=Observation("pedestrian", "paper"))

    @property
    def sample(self):
        return True

    def init(self, agents, batch):
        return jnp.zeros(batch, jnp.int32)

    def act(self, key, memory, observation):
        coin = jax.vmap(lambda k: jax.random.bernoulli(k, 0.8, observation.shape[1:2]), out_axes=-1)(key)
        return coin.astype(jnp.int32), memory + 1


@pytest.fixture(scope="session")
def driver():
    return RouteFollower()


@pytest.fixture(scope="session")
def undecided():
    return Undecided()


@pytest.fixture(scope="session")
def rows(street, driver, undecided):
    """40 episodes in batches of 16."""
    return evaluate(street, {"driver": driver, "pedestrian": undecided}, Drawn(street, 7, 40), batch=BATCH)


@pytest.fixture(scope="session")
def compared(street, driver, undecided):
    """Two drivers among two populations: results and rows."""
    drivers = {"route-follower": driver, "random": Random()}
    populations = {"undecided": undecided, "always-go": AlwaysGo()}
    return evaluate_grid(street, drivers, populations, Drawn(street, 7, 24), batch=BATCH)


@pytest.fixture(scope="module")
def often(street):
    """Everybody jaywalks at least as often as not."""
    return with_jaywalk_multiplier(street, 1.0)
