"""Policies: trained networks and fixed rules. A name is imported when it is first used."""

from __future__ import annotations

from jaxwalk.lazy import imported_when_used

_HOMES = {
    "DRIVERS": "drivers",
    "POPULATIONS": "pedestrians",
    "AlwaysGo": "pedestrians",
    "ConstantSpeed": "drivers",
    "Groups": "groups",
    "LearnedPolicy": "learned",
    "Mixture": "mixture",
    "Oracle": "oracle",
    "PolicyError": "learned",
    "Random": "drivers",
    "RouteFollower": "drivers",
    "RuleBased": "drivers",
    "RuleBasedBraking": "drivers",
    "SHIPPED": "shipped",
    "SHIELDS": "shielding",
    "Shielded": "shielding",
    "load_policy": "learned",
    "read_metadata": "learned",
    "save_policy": "learned",
    "shielded": "shielding",
    "shipped_policy": "shipped",
}
"""Each public name, and the module of this package that defines it."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

__getattr__, __dir__ = imported_when_used(__name__, _HOMES)
