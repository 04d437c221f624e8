"""Rule-based pedestrians. Each rule is a `jaxwalk.interfaces.Policy`.

It decides when people cross: whether somebody at the kerb goes or waits. How they cross, on the crosswalk or as a
jaywalk, is drawn by the simulator (`jaxwalk.sim.pedestrian`). Who isn't at the kerb goes on, but for rules that
judge the car on the roadway too, such as `GivesWay`.
"""

from __future__ import annotations

from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, Key

from jaxwalk.interfaces import Policy, View
from jaxwalk.policies.diffusion import Diffusion
from jaxwalk.policies.distracted import Distracted
from jaxwalk.policies.gap_acceptance import GapAccepting
from jaxwalk.policies.gives_way import GivesWay
from jaxwalk.policies.pedsumo import PedSumo
from jaxwalk.sim.observation import Observation

GO = 1
"""The action "walk on"; 0 is "wait"."""


class AlwaysGo(eqx.Module):
    """Walks on at every step, whatever happens."""

    view: View = eqx.field(static=True, default=Observation("pedestrian", "paper"))
    """What it sees (it uses only its shape)."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(
        self, key: Key[Array, "*batch"], memory: None, observation: Float[Array, "feature ped *batch"]
    ) -> tuple[Int[Array, "ped *batch"], None]:
        """Return "walk on" for everybody."""
        return jnp.full(observation.shape[1:], GO, jnp.int32), memory


POPULATIONS: dict[str, Callable[[], Policy]] = {
    "always-go": AlwaysGo,
    "gap-acceptance": GapAccepting,
    "diffusion": Diffusion,
    "distracted": Distracted,
    "pedsumo": PedSumo,
    "campus": GivesWay,
}
"""Rule-based pedestrians by name: call an entry to make the policy."""
