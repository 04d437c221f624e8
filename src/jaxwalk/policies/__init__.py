"""Everybody who can decide: trained networks and fixed rules. Names are loaded when they are first used."""

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
"""Public names and the modules of this package that define them."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return list(__all__)
