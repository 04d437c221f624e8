"""Why a number gives no street."""

from __future__ import annotations


class Refusal(ValueError):
    """A number's street can't be driven or walked. The message has no numbers in it, so that reasons can be counted."""
