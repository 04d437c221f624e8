"""Settings of an evaluation: how a policy acts, and how often people jaywalk."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, TypeVar

import equinox as eqx
import jax.numpy as jnp

from jaxwalk.interfaces import Roles
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import check_multiplier
from jaxwalk.sim.world import as_written

SAMPLES: Roles[bool] = {"driver": False, "pedestrian": True}
"""Whether a role's policy samples its actions in an evaluation by default; else it takes the likeliest."""

P = TypeVar("P")


def acts_by(policy: Any) -> str:
    """Return ``sample`` for a policy that draws its actions at random, ``mode`` for one that takes the likeliest."""
    return "sample" if getattr(policy, "sample", False) else "mode"


def with_mode(policy: P, *, sample: bool) -> P:
    """Return the policy, sampling or not. A rule has no choice and stays the same."""
    if isinstance(policy, eqx.Module) and "sample" in {field.name for field in fields(policy)}:
        return replace(policy, sample=sample)
    return policy


def with_jaywalk_multiplier(street: Street, multiplier: float) -> Street:
    """Return the street with P(jaywalk | decision) = tendency x ``multiplier``, without compiling anything again.

    Raise ValueError for a negative or infinite multiplier.
    """
    check_multiplier(multiplier)
    return eqx.tree_at(lambda s: s.world.rules.jaywalk_multiplier, street, jnp.float32(multiplier))


def jaywalk_multiplier(street: Street) -> float:
    """Return the street's multiplier as it was written: 0.1, not 0.10000000149."""
    return as_written(street.world.rules.jaywalk_multiplier)
