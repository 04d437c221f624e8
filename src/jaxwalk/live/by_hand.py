"""A driver that a person can take over from: while somebody drives, their pedals and steering replace its action."""

from __future__ import annotations

from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import Policy, View
from jaxwalk.policies import RouteFollower
from jaxwalk.policies.shielding import Behind

DRIVES, PEDAL, STEERING = 0, 1, 2
"""Places in `ByHand.hand`."""


class ByHand(eqx.Module):
    """A policy around a driver. The driver decides at every step all the same, so its memory stays as it should be."""

    driver: Policy
    follower: RouteFollower
    """Steers along the route where the person doesn't steer."""
    hand: Float[Array, "3"]
    """Whether a person drives (1 or 0), acceleration and steering as shares of their limits; a steering of NaN follows
    the route."""

    @property
    def view(self) -> View:
        """What the driver and the follower see."""
        return Behind(self.driver.view, self.follower.view)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Any:
        """Return the driver's memory."""
        return self.driver.init(agents, batch)

    def act(self, key: Key[Array, "*batch"], memory: Any, seen: Any) -> tuple[Float[Array, "2 *batch"], Any]:
        """Return the person's action, or the driver's where nobody took over, and the driver's next memory."""
        shown, route = seen
        action, after = self.driver.act(key, memory, shown)
        (_, along), _ = self.follower.act(key, None, route)
        steering = jnp.where(jnp.isnan(self.hand[STEERING]), along, self.hand[STEERING])
        hand = jnp.stack([jnp.full_like(steering, self.hand[PEDAL]), steering])
        return jnp.where(self.hand[DRIVES] > 0, hand.astype(action.dtype), action), after
