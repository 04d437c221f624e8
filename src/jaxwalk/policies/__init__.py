"""Policies: trained networks and fixed rules. A name is imported when it is first used."""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "DRIVERS": "drivers",
    "POPULATIONS": "pedestrians",
    "AlwaysGo": "pedestrians",
    "ConstantSpeed": "drivers",
    "LearnedPolicy": "learned",
    "Oracle": "oracle",
    "PolicyError": "learned",
    "Random": "drivers",
    "RouteFollower": "drivers",
    "RuleBased": "drivers",
    "RuleBasedBraking": "drivers",
    "SHIPPED": "shipped",
    "load_policy": "learned",
    "read_metadata": "learned",
    "save_policy": "learned",
    "shipped_policy": "shipped",
}
"""Each public name, and the module of this package that defines it."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return list(__all__)
