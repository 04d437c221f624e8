"""Pedestrian populations that are rules. Each is a `jaxwalk.interfaces.Policy`."""

from __future__ import annotations

from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, Key

from jaxwalk.interfaces import Policy, View
from jaxwalk.sim.observation import Observation

GO = 1
"""The action of a pedestrian who walks on (0: waits)."""


class AlwaysGo(eqx.Module):
    """Everybody walks on at every step, whatever comes."""

    view: View = eqx.field(static=True, default=Observation("pedestrian", "paper"))
    """What it sees (it uses only its shape)."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """It remembers nothing."""
        return None

    def act(
        self, key: Key[Array, "*batch"], memory: None, observation: Float[Array, "feature ped *batch"]
    ) -> tuple[Int[Array, "ped *batch"], None]:
        """Go, for all."""
        return jnp.full(observation.shape[1:], GO, jnp.int32), memory


POPULATIONS: dict[str, Callable[[], Policy]] = {"always-go": AlwaysGo}
"""Pedestrian rules by name: call one to make it."""
