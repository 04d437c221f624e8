"""The error of an import."""

from __future__ import annotations


class ImportRefusal(ValueError):
    """A source can't be imported. The message is one line: what, where, and what to do."""
