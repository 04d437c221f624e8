"""The speed differential tried on drivers whose truth is known: does it find what is there, and only that?

Intervals are of 95 %: of true zeros, one in twenty leaves its interval by chance. With this seed none does.
"""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import pytest

from jaxwalk.evaluation import evaluate
from jaxwalk.metrics import SPEED_DIFFERENTIAL, summarise
from jaxwalk.policies import AlwaysGo
from jaxwalk.policies.pursuit import pursue
from jaxwalk.scenarios import Drawn
from jaxwalk.sim import observation
from jaxwalk.sim.driver_features import ON_ROUTE
from jaxwalk.sim.environment import Street
from jaxwalk.sim.features import SPEED, Feature, share
from sim.maps import rectangles

EPISODES = 2048
SLOW = 3.0
"""[m/s]"""
NOTHING = 1e-3
"""Speeds that differ by less are the same [m/s]."""


def crosswalk_ahead(moment):
    """Whether a crosswalk is within 10 m ahead."""
    car = moment.state.vehicle
    ahead = jnp.arange(0.0, 10.1, 2.0).reshape(-1, *(1,) * car.x.ndim)
    x, y = car.x + ahead * car.cos, car.y + ahead * car.sin
    at_crosswalk = [(x > x0) & (x < x1) & (y > y0) & (y < y1) for x0, y0, x1, y1 in rectangles("crosswalks")]
    return (jnp.stack(at_crosswalk).any(axis=(0, 1)),)


KNOWN = (
    *ON_ROUTE,
    Feature("crosswalk", 1, share, crosswalk_ahead),
    Feature("crosswalk_user", 1, share, lambda moment: (moment.state.foresight.crosswalk_user,)),
)
"""What a driver of known truth goes by: its route; a crosswalk within 10 m ahead; somebody on one close ahead."""


class Known(eqx.Module):
    """Follows its route; slow for one of the last two features of the observation, or for nothing."""

    slow_for: jax.Array

    @property
    def view(self):
        return observation.Observation("driver", "known")

    def init(self, agents, batch):
        return None

    def act(self, key, memory, seen):
        target = jnp.where(jnp.tensordot(self.slow_for, seen[-2:], 1) > 0, SLOW, SPEED)
        return jnp.stack([jnp.clip(target - seen[0] * SPEED, -1, 1), pursue(seen[6:22])]), memory


pytestmark = pytest.mark.long
BLIND, CROSSWALKS, CROSSWALK_USERS = (0, 0), (1, 0), (0, 1)


@pytest.fixture(scope="module")
def found(compiled_well):
    """The speed differential of each driver among always-go, by what it slows down for."""
    street, source = Street.create(), Drawn(Street.create(), 2, EPISODES)
    observation.OBSERVATIONS["driver"]["known"] = KNOWN
    try:
        drivers = {what: Known(jnp.array(what, float)) for what in (BLIND, CROSSWALKS, CROSSWALK_USERS)}
        rows = {
            what: evaluate(street, {"driver": driver, "pedestrian": AlwaysGo()}, source, batch=512)
            for what, driver in drivers.items()
        }
        return {what: summarise(played)[SPEED_DIFFERENTIAL] for what, played in rows.items()}
    finally:
        del observation.OBSERVATIONS["driver"]["known"]


def contains_zero(estimate) -> bool:
    return estimate.low <= NOTHING and estimate.high >= -NOTHING


def test_a_driver_that_sees_nobody_shows_nothing_beyond_the_placebo(found):
    assert all(contains_zero(here.placebo.difference) for here in found[BLIND])
    assert all(contains_zero(here.matched) for here in found[BLIND])
    # the raw number of the farthest bin is not zero: people jaywalk where cars have come up to speed
    assert found[BLIND][3].pooled.difference.low > 0.1


def test_a_driver_that_slows_at_every_crosswalk_shows_a_raw_differential_that_the_placebo_explains(found):
    for here in found[CROSSWALKS][:3]:
        assert here.pooled.difference.low > 0.3
        assert here.placebo.ghosts.difference.low > 0.3
    assert all(contains_zero(here.placebo.difference) for here in found[CROSSWALKS])
    nearest = found[CROSSWALKS][0]
    assert abs(nearest.matched.value) < nearest.pooled.difference.value / 3  # (the squares are coarse: not nothing)


def test_a_driver_that_slows_for_crosswalk_users_alone_is_found_out(found):
    for here in found[CROSSWALK_USERS][1:3]:
        assert here.placebo.difference.low > 0.3
        assert here.matched.low > 0.3
