"""What names of shielded drivers mean: ``co-trained+rss``. This module imports no JAX."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

SHIELD_NAMES = ("predictive", "predictive-steady", "rss", "cbf")
"""The shields (`jaxwalk.policies.shielding`)."""


def unshielded(role: str, name: str) -> tuple[str, str | None]:
    """Return the driver and the shield in a name such as ``co-trained+rss``; for any other the name itself and None."""
    driver, plus, shield = name.rpartition("+")
    if role != "driver" or not plus or not driver or shield not in SHIELD_NAMES or Path(name).exists():
        return name, None
    return driver, shield


def with_shield(drivers: Iterable[str], shield: str | None) -> tuple[str, ...]:
    """Return the names of the drivers with a shield around each; the same names without one."""
    return tuple(drivers) if shield is None else tuple(f"{driver}+{shield}" for driver in drivers)
