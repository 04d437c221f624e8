"""How numbers and lists are written in sentences."""

from __future__ import annotations

from collections.abc import Sequence

MOST_NAMED = 4
"""Longer lists are cut off."""


def counted(number: int, what: str) -> str:
    """Return a number of things in words, as in ``1 scenario`` or ``2,000 scenarios``; ``what`` is the singular."""
    return f"{number:,} {what}" + ("" if number == 1 else "s")


def first_of(names: Sequence[str], what: str) -> str:
    """Return names in words, as in ``a, b, c, d and 16 more maps``; ``what`` is the singular of what they name."""
    more = len(names) - MOST_NAMED
    return ", ".join(names[:MOST_NAMED]) + (f" and {counted(more, f'more {what}')}" if more > 0 else "")
