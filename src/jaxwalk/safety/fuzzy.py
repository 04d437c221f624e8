"""The fuzzy safety model (Mattas et al. 2020, Accident Analysis & Prevention 148, 105794; UN R157 has it too).

Two fuzzy numbers between 0 (safe) and 1 (unsafe) say how hard a driver brakes. The formulas and parameters are those of
the authors' program (github.com/ec-jrc/JRC-FSM).
"""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

SHARPEST = 1e-6
"""Safe and unsafe distances lie at least this far apart [m]."""


@dataclass(frozen=True)
class FuzzyLimits:
    """The parameters of the model."""

    reaction: float = 0.75
    """The driver's reaction time tau [s]."""
    comfortable: float = 4.0
    """Braking that the driver likes [m/s2]."""
    hardest: float = 6.0
    """Braking in an emergency [m/s2]."""
    leader: float = 7.0
    """How hard the other one may brake [m/s2]."""
    margin: float = 2.0
    """Distance to keep when standing, and again before braking begins [m]."""
    headstart: float = 0.1
    """The other one is reacted to if it is this late in coming into the way [s]."""


def proactive_fuzzy_safety(
    gap: Float[Array, "..."],
    speed: Float[Array, "..."],
    leader_speed: Float[Array, "..."],
    limits: FuzzyLimits,
) -> Float[Array, "..."]:
    """Return PFS: 1 where the gap wouldn't do if the other one braked hard, 0 where it would with comfort, in [0, 1].

    Args:
        gap: distance between the surfaces [m].
        speed: the car's speed [m/s].
        leader_speed: the other one's speed in the car's direction [m/s]; who comes towards the car counts as standing,
            which is ours.
        limits: the model's parameters.
    """
    base = speed * limits.reaction - jnp.maximum(leader_speed, 0) ** 2 / (2 * limits.leader)
    safe = base + speed**2 / (2 * limits.comfortable) + limits.margin
    unsafe = base + speed**2 / (2 * limits.hardest)
    return _between(gap - limits.margin, safe, unsafe)


def critical_fuzzy_safety(
    gap: Float[Array, "..."],
    speed: Float[Array, "..."],
    leader_speed: Float[Array, "..."],
    acceleration: Float[Array, "..."],
    limits: FuzzyLimits,
) -> Float[Array, "..."]:
    """Return CFS: 1 where the gap wouldn't do even if the other one kept its speed, in [0, 1]; 0 if none closes it.

    ``acceleration`` is the car's own now [m/s2]; the other arguments are those of `proactive_fuzzy_safety`.
    """
    goes_on = jnp.maximum(acceleration, -limits.comfortable)
    closing = speed - leader_speed
    later = closing + goes_on * limits.reaction
    base = (closing + goes_on * limits.reaction / 2) * limits.reaction
    reacting = _between(gap, base + later**2 / (2 * limits.comfortable), base + later**2 / (2 * limits.hardest))
    stopping = gap < closing**2 / jnp.maximum(2 * jnp.abs(acceleration), SHARPEST)
    return jnp.where(closing > 0, jnp.where(later < 0, stopping, reacting), 0.0)


def fuzzy_braking(
    proactive: Float[Array, "..."], critical: Float[Array, "..."], limits: FuzzyLimits
) -> Float[Array, "..."]:
    """Return how hard the driver wants to brake [m/s2]: by CFS between comfortable and hardest, else PFS of comfort."""
    emergency = limits.comfortable + critical * (limits.hardest - limits.comfortable)
    return jnp.where(critical > 0, emergency, proactive * limits.comfortable)


def comes_into_the_way(
    aside: Float[Array, "..."],
    approach: Float[Array, "..."],
    passing: Float[Array, "..."],
    closing: Float[Array, "..."],
    headstart: float = FuzzyLimits.headstart,
) -> Bool[Array, "..."]:
    """Return whether somebody is in the car's way, or comes into it before the car is past: the model's lateral check.

    Args:
        aside: distance to the car's way [m]; 0 or less in it.
        approach: how fast that distance shrinks [m/s].
        passing: way that the car drives until it is past them: gap and both lengths [m].
        closing: how fast the car approaches them [m/s].
        headstart: they may come this much later [s].
    """
    arrives = aside / jnp.maximum(approach, SHARPEST)
    past = passing / jnp.maximum(closing, SHARPEST) + headstart
    return (aside <= 0) | ((approach > 0) & (arrives <= past))


def _between(value: Array, safe: Array, unsafe: Array) -> Array:
    """Return 0 from the safe distance on, 1 up to the unsafe one, and linearly between them."""
    return jnp.clip((safe - value) / jnp.maximum(safe - unsafe, SHARPEST), 0, 1)
