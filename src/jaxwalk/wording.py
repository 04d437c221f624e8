"""How numbers are written in sentences."""

from __future__ import annotations


def counted(number: int, what: str) -> str:
    """Return a number of things in words, as in ``1 scenario`` or ``2,000 scenarios``; ``what`` is the singular."""
    return f"{number:,} {what}" + ("" if number == 1 else "s")
