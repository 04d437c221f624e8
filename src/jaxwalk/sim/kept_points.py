"""Kept scenarios mixed into drawn ones: a training meets again what a search has found."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Key


class KeptPoints(eqx.Module):
    """Points of the unit cube of all draws, and how often one of them takes the place of a drawn one."""

    points: Float[Array, "scenario number"]
    """As `jaxwalk.sim.scenario.from_uniforms` takes them, in [0, 1)."""
    share: Float[Array, ""]
    """Probability of a kept scenario, in [0, 1]; each of them is as likely as any other."""

    def mixed(self, key: Key[Array, ""], drawn: Float[Array, " number"]) -> Float[Array, " number"]:
        """Return a kept point or, where chance has it so, the drawn one."""
        chance, which = jax.random.uniform(key, (2,))
        at = jnp.floor(which * len(self.points)).astype(jnp.int32)
        return jnp.where(chance < self.share, self.points[at], drawn)
