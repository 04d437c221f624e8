"""A map as text, with its name and its hash: what run folders and results keep, so that no map changes unnoticed."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field

HASH_DIGITS = 16
"""Number of hexadecimal digits of a map's hash."""


@dataclass(frozen=True)
class MapText:
    """The text of a map, and what identifies it."""

    name: str
    """Name of a bundled map, or of a file without its folder."""
    hash: str
    """The first `HASH_DIGITS` digits of the SHA-256 of the text as UTF-8."""
    text: str | None = field(default=None, repr=False)
    """The content of the map file; None in a document that names a bundled map."""

    @staticmethod
    def of(name: str, text: str) -> MapText:
        """Return a text with its hash."""
        return MapText(name, text_hash(text), text)

    def __str__(self) -> str:
        """Return the name."""
        return self.name


def text_hash(text: str) -> str:
    """Return the hash of a map's text."""
    return hashlib.sha256(text.encode()).hexdigest()[:HASH_DIGITS]


def map_labels(maps: Sequence[MapText]) -> tuple[str, ...]:
    """Return a name for each map; with its hash where different maps have the same name."""
    hashes = {name: {x.hash for x in maps if x.name == name} for name in {x.name for x in maps}}
    return tuple(x.name if len(hashes[x.name]) == 1 else f"{x.name} ({x.hash})" for x in maps)
