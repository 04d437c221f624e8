"""The clearance rule: a driver of three lines, and the strong simple baseline of every published table."""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.pursuit import pursue
from jaxwalk.policies.world_numbers import from_world
from jaxwalk.sim.manoeuvres import ACCELERATE, FAR, HOLD
from jaxwalk.sim.observation import FOOTPRINT, Observation, part


class ClearanceRule(eqx.Module):
    """Follows its route at the fastest of accelerating, holding and braking that keeps clear of people.

    Each manoeuvre's clearance over the next 3 s is predicted as for a trained driver (`jaxwalk.sim.prediction`), from
    the car's rectangle to people's bodies. The rule is ours. It steers by pure pursuit.
    """

    clearance: float = eqx.field(static=True, default=1.0)
    """Predicted clearance that it keeps [m]."""
    wheelbase: float = from_world("wheelbase")
    """Distance between the car's axles [m]."""
    max_steering: float = from_world("max_steering")
    """The car's largest steering angle [rad]."""
    view: View = eqx.field(static=True, default=Observation("driver", FOOTPRINT))
    """What it sees."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(
        self, key: Key[Array, "*batch"], memory: None, observation: Float[Array, "feature *batch"]
    ) -> tuple[Float[Array, "2 *batch"], None]:
        """Return full throttle, none or full braking, and the steering that follows the route."""
        clear = observation[part("driver", FOOTPRINT, "clearance")] * FAR > self.clearance
        throttle = jnp.where(clear[ACCELERATE], 1.0, jnp.where(clear[HOLD], 0.0, -1.0))
        route = observation[part("driver", FOOTPRINT, "route")]
        steering = pursue(route, wheelbase=self.wheelbase, max_steering=self.max_steering)
        return jnp.stack([throttle, steering]), memory
