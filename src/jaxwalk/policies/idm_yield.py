"""A driver that follows people who are in its way as it would follow a car."""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.policies.corridor_driver import CorridorDriver
from jaxwalk.safety.idm import FollowingStyle, idm_acceleration

SLOWEST = 0.1
"""Top speeds count as at least this [m/s]."""


class IdmYield(CorridorDriver):
    """Accelerates and brakes by the Intelligent Driver Model, with whoever is on course as its leader.

    The model is that of Treiber, Hennecke and Helbing (2000). Its leader is a car there; that it is the person who
    makes the model brake hardest is ours, as are a = 1.5 and b = 2 m/s2. The desired speed is the car's top speed where
    it is. Who is on course says the lateral check of the fuzzy safety model.
    """

    style: FollowingStyle = eqx.field(static=True, default=FollowingStyle())
    """The model's parameters."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(
        self, key: Key[Array, "*batch"], memory: None, observation: Float[Array, "feature *batch"]
    ) -> tuple[Float[Array, "2 *batch"], None]:
        """Return the model's acceleration within the car's limits, and the steering along the route."""
        ahead = self.look(observation)
        gap = jnp.where(ahead.on_course, ahead.gap, jnp.inf)
        top = jnp.maximum(ahead.top, SLOWEST)
        acceleration = idm_acceleration(ahead.speed, top, gap, ahead.speed - ahead.along_speed, self.style)
        return self.act_with(acceleration.min(axis=0), observation), memory
