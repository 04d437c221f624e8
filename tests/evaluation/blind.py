"""A driver who doesn't look and people who may lurk; the same kinds everywhere, so that little is compiled."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp

from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.sim.observation import Observation, part


class Car(RouteFollower):
    """Drives along its route without looking, or stands; from a step on, its throttle isn't a number."""

    throttle: jax.Array = eqx.field(kw_only=True)
    broken_from: jax.Array = eqx.field(default_factory=lambda: jnp.int32(10_000), kw_only=True)

    def init(self, agents, batch):
        return jnp.zeros(batch, jnp.int32)

    def act(self, key, memory, observation):
        action, _ = super().act(key, None, observation)
        return action.at[0].set(jnp.where(memory < self.broken_from, self.throttle, jnp.nan)), memory + 1


class People(AlwaysGo):
    """Go; lurkers stand at the kerb until a fast car is less than a second away, and then step out before it."""

    view: Observation = eqx.field(static=True, default=Observation("pedestrian", "kerb"))
    lurk: jax.Array = eqx.field(kw_only=True)

    def act(self, key, memory, observation):
        seen = {name: observation[part("pedestrian", "kerb", name)] for name in ("car_motion", "miss", "to_kerb")}
        fast = seen["car_motion"][0] * 8.33 > 7
        hit = (seen["miss"][0] * 10 < 1) & (seen["miss"][1] * 8 < 0.9)
        at_the_kerb = (seen["to_kerb"][0] > 0) & (seen["to_kerb"][0] < 0.25)
        return 1 - (self.lurk & at_the_kerb & ~(fast & hit)).astype(jnp.int32), memory


# the same kinds of policies everywhere: numbers in them compile nothing anew
BLIND, STANDING = Car(throttle=jnp.float32(1)), Car(throttle=jnp.float32(-1))
WALKERS, LURKERS = People(lurk=jnp.array(False)), People(lurk=jnp.array(True))
BLIND_ONE = {"driver": BLIND, "pedestrian": WALKERS}
