"""Costs of the car: what it should do rarely, counted beside its reward. A street counts those that it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import jax.numpy as jnp
from jaxtyping import Array

from jaxwalk.sim import prediction
from jaxwalk.sim.reward import Transition

CRITICAL = 1.5
"""A smaller time to collision is critical [s]: Hydén (1987), as in the metrics."""


def _contact(t: Transition) -> Array:
    """Return 1 in the step that ends an episode with a contact, by the world's kind of contact."""
    return t.events.collision.astype(jnp.float32)


def _impact_speed(t: Transition) -> Array:
    """Return the speed of the car in a contact [m/s]."""
    return jnp.where(t.events.collision, t.after.vehicle.speed, 0.0)


def _critical_time(t: Transition) -> Array:
    """Return the duration of the step [s] if the moving car, at this speed along its route, is about to hit somebody.

    That is: a contact, or almost one (`jaxwalk.sim.manoeuvres.CONFLICT`), is predicted within `CRITICAL` seconds.
    """
    rules = t.world.rules
    conflict = prediction.conflict_at_held_speed(t.world, t.scenario, t.after)
    critical = (conflict < CRITICAL) & (t.after.vehicle.speed >= rules.moving_speed)
    return jnp.where(critical, rules.dt, 0.0)


DRIVER_COSTS: dict[str, Callable[[Transition], Array]] = {
    "contact": _contact,
    "impact_speed": _impact_speed,
    "critical_time": _critical_time,
}
"""The driver's costs, for each step."""
PAID_ONCE = ("contact", "impact_speed")
"""Those that an episode has in its last step only. So its sum over the episode is what that step costs."""


def counted(names: Sequence[str], transition: Transition) -> dict[str, Array]:
    """Return the named costs of a step."""
    return {name: DRIVER_COSTS[name](transition) for name in names}


def check_costs(names: Sequence[str]) -> None:
    """Raise ValueError for a name without a cost."""
    for name in names:
        if name not in DRIVER_COSTS:
            raise ValueError(f"costs.driver.{name} is no cost; there are: {', '.join(DRIVER_COSTS)}")
