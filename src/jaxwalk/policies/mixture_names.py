"""What names of mixtures mean: ``gap-acceptance:0.7+always-go:0.3``. This module imports no JAX."""

from __future__ import annotations

from pathlib import Path

MIXED = "as in gap-acceptance:0.7+always-go:0.3"
ROUNDING = 1e-6
"""Shares are 1 together, to this."""


class MixtureError(ValueError):
    """The name of no proper mixture. The message says what to do, in one line."""


def mixture_of(role: str, name: str) -> dict[str, float]:
    """Return the kinds in a name such as ``gap-acceptance:0.7+always-go:0.3``, each with its share of the people.

    Empty for any other name. Raise MixtureError for shares that aren't above 0, or aren't 1 together.
    """
    if role != "pedestrian" or "+" not in name or Path(name).exists():
        return {}
    shares: dict[str, float] = {}
    for part in name.split("+"):
        kind, _, share = part.rpartition(":")
        try:
            number = float(share)
        except ValueError:
            number = 0.0
        if not kind or not 0 < number < 1:
            raise MixtureError(f"{name}: {part!r} needs a name and a share between 0 and 1, {MIXED}")
        if kind in shares:
            raise MixtureError(f"{name}: names {kind} twice; name each kind once, {MIXED}")
        shares[kind] = number
    if abs(sum(shares.values()) - 1) > ROUNDING:
        raise MixtureError(f"{name}: the shares are {sum(shares.values()):g} together, not 1; change one, {MIXED}")
    return shares
