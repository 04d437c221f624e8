"""The cautious rule: the clearance rule that slows where it can't see who may step out."""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.clearance_rule import ClearanceRule
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import AWARE, Observation, part, size


class CautiousRule(eqx.Module):
    """Drives like `ClearanceRule`, but at walking pace while a place beyond a kerb close ahead is hidden.

    From 3 m/s a car that brakes with 7.6 m/s2 stops within 0.6 m. The rule is ours: it shows which contacts a driver on
    the road could avoid if it were in no hurry.
    """

    rule: ClearanceRule = eqx.field(default_factory=ClearanceRule)
    """How it drives otherwise."""
    slow: float = eqx.field(static=True, default=3.0)
    """Its speed beside hidden places [m/s]."""
    points: int = eqx.field(static=True, default=4)
    """It looks beside this many points of its route ahead (``jaxwalk.sim.map_tables.POINTS``): up to 10 m."""
    view: View = eqx.field(static=True, default=Observation("driver", AWARE))
    """What it sees."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(
        self, key: Key[Array, "*batch"], memory: None, observation: Float[Array, "feature *batch"]
    ) -> tuple[Float[Array, "2 *batch"], None]:
        """Return the clearance rule's action, or what brings the car to its slow speed if that is less."""
        (throttle, steering), _ = self.rule.act(key, None, observation[: size("driver", self.rule.view.name)])
        hidden = observation[part("driver", AWARE, "hidden_sides")][: 2 * self.points].max(axis=0) > 0
        (speed,) = observation[part("driver", AWARE, "speed")] * SPEED
        calm = jnp.clip(self.slow - speed, -1, 1)
        return jnp.stack([jnp.where(hidden, jnp.minimum(throttle, calm), throttle), steering]), memory
