"""A shield around a driver: a policy whose action is the driver's, or a safer one (``docs/shields.md``)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.interfaces import Box, Moment, Policy, View
from jaxwalk.policies.shields.cbf_shield import CbfShield
from jaxwalk.policies.shields.predictive_shield import PredictiveShield
from jaxwalk.policies.shields.rss_shield import RssShield
from jaxwalk.policies.shields.shield_scene import Shield, ShieldScene

SHIELDS: dict[str, Callable[[], Shield]] = {
    "predictive": PredictiveShield,
    "predictive-steady": partial(PredictiveShield, acceleration=1.0),
    "rss": RssShield,
    "cbf": CbfShield,
}
"""Shields by name: call an entry to make the shield."""
ACTION = Box(2)
"""The space of a driver's action."""


class Intervention(eqx.Module):
    """What a shield did in a step."""

    changed: Bool[Array, "*batch"]
    """Whether it changed the driver's action."""
    infeasible: Bool[Array, "*batch"]
    """Whether nothing that it could do was safe by its rule."""


@dataclass(frozen=True)
class Behind:
    """What the driver sees, and what its shield sees. Its name is that of the driver's view."""

    driver: View
    shield: View

    @property
    def name(self) -> str:
        """The name of the driver's view."""
        return self.driver.name

    def __call__(self, moment: Moment) -> tuple[Any, Any]:
        """Return both."""
        return self.driver(moment), self.shield(moment)


class Shielded(eqx.Module):
    """A driver whose actions a shield corrects.

    An action that isn't in its space is left as it is: what plays a broken driver says so.
    """

    driver: Policy
    shield: Shield

    @property
    def view(self) -> View:
        """What both see."""
        return Behind(self.driver.view, self.shield.view)

    @property
    def sample(self) -> bool:
        """Whether the driver draws its actions at random."""
        return getattr(self.driver, "sample", False)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Any:
        """Return the driver's memory; a shield has none."""
        return self.driver.init(agents, batch)

    def act(
        self, key: Key[Array, "*batch"], memory: Any, seen: tuple[Any, ShieldScene]
    ) -> tuple[Float[Array, "2 *batch"], Any]:
        """Return the driver's action, or what the shield does instead, and the driver's next memory."""
        action, after, _ = self.decide(key, memory, seen)
        return action, after

    def decide(
        self, key: Key[Array, "*batch"], memory: Any, seen: tuple[Any, ShieldScene]
    ) -> tuple[Float[Array, "2 *batch"], Any, Intervention]:
        """Return the same, and what the shield did."""
        shown, scene = seen
        action, after = self.driver.act(key, memory, shown)
        verdict, sound = self.shield.judge(action, scene), ACTION.contains(action)
        does = jnp.where(sound & ~verdict.safe, verdict.instead.astype(action.dtype), action)
        changed = sound & (does != action).any(axis=0)
        return does, after, Intervention(changed, sound & verdict.infeasible)


def shielded(driver: Policy, shield: str | Shield) -> Shielded:
    """Return a driver behind a shield, which is given by its name in `SHIELDS` or as itself.

    Raise ValueError for a name that doesn't exist, and for a driver that has a shield already.
    """
    if isinstance(driver, Shielded):
        raise ValueError("a driver has one shield at most; put the other one around the driver itself")
    if isinstance(shield, str):
        if shield not in SHIELDS:
            raise ValueError(f"no shield '{shield}'; there are: {', '.join(SHIELDS)}")
        shield = SHIELDS[shield]()
    return Shielded(driver, shield)
