"""The policies of roles that the user of an adapter does not play, and the rewards of all roles."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jaxwalk.evaluation import SAMPLES, with_mode
from jaxwalk.interfaces import Policy
from jaxwalk.policies import DRIVERS, POPULATIONS, SHIPPED, load_policy, shipped_policy
from jaxwalk.policies.mixture import Mixture
from jaxwalk.policies.mixture_names import mixture_of
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.policies.shielding import shielded
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.recipes import RECIPES
from jaxwalk.sim.sim_config import SimConfig

Weights = str | Mapping[str, float]
"""A recipe's name, or weights of reward terms (`jaxwalk.sim.reward`)."""

_RULES: dict[str, Any] = {"driver": DRIVERS, "pedestrian": POPULATIONS}


class AdapterError(ValueError):
    """Raised for an impossible option of an adapter; one line says why and what to do."""


def player(role: str, who: str | Path | Policy, rules: SimConfig) -> Policy:
    """Return a role's policy: a `Policy` itself, a rule or shipped policy by name, a file, or a mixture of people.

    A rule by name knows the numbers of the world with these rules. A trained policy acts as in an evaluation:
    pedestrians sample their actions, a driver takes the likeliest one.
    """
    if not isinstance(who, str | Path):
        return who
    bare, shield = unshielded(role, str(who))
    if shield is not None:
        return shielded(player(role, bare, rules), shield)
    if who in _RULES[role]:
        return with_limits(_RULES[role][who](), rules)
    mixed = mixture_of(role, str(who))
    if mixed:
        return Mixture(tuple(player(role, kind, rules) for kind in mixed), tuple(mixed.values()))
    file = shipped_policy(role, str(who)) or Path(who)
    if not file.is_file():
        known = ", ".join((*_RULES[role], *SHIPPED[role]))
        raise AdapterError(f"{who}: no {role} of that name ({known}) and no policy file; check the name")
    return with_mode(load_policy(file, role), sample=SAMPLES[role])


def weights_of(role: str, weights: Weights) -> Mapping[str, float]:
    """Return the weights of a role's reward terms: as given, or those of the recipe with that name."""
    if not isinstance(weights, str):
        return weights
    if weights not in RECIPES:
        raise AdapterError(f"no recipe {weights!r} to pay the {role} by; there are: {', '.join(RECIPES)}")
    recipe = RECIPES[weights]
    return recipe.driver_weights if role == "driver" else recipe.pedestrian_weights
