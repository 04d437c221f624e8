"""The source of scenarios, as evaluation needs it: it gives scenarios by number, and identifies its set."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from typing import Any, Protocol, runtime_checkable

import jax
import numpy as np
from jaxtyping import Array, Int, Key

HASHED_AT_ONCE = 512
"""Number of scenarios that are made at once for the hash."""
HASH_DIGITS = 16
"""Number of hexadecimal digits of a source's hash."""


@runtime_checkable
class Source(Protocol):
    """A numbered set of scenarios. Scenario i is always the same, whatever else is taken with it."""

    def __len__(self) -> int:
        """Return the number of scenarios; they are numbered 0, 1, ..."""
        ...

    def take(self, numbers: Int[np.ndarray, "episode"]) -> tuple[Any, Key[Array, "episode"]]:
        """Return the scenarios of these numbers as a batch, arrays ``(..., episode)``, and a key for each.

        A key is for the policies that play the scenario, and for what is drawn beside it, such as ghosts.
        """
        ...

    def hash(self) -> str:
        """Return `HASH_DIGITS` hexadecimal digits that identify everything in the set that chance decides."""
        ...

    def describe(self) -> dict[str, Any]:
        """Return what results state about the set, as plain JSON."""
        ...


def source_hash(source: Source) -> str:
    """Return the hash of a source's scenarios: SHA-256 over all their arrays, scenario after scenario.

    Equal sets have equal hashes, on every machine.
    """
    return hash_of(scenario_bytes(source, range(len(source))))


def hash_of(contents: Iterable[bytes]) -> str:
    """Return the first `HASH_DIGITS` digits of the SHA-256 of contents, one after the other."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(content)
    return digest.hexdigest()[:HASH_DIGITS]


def scenario_bytes(source: Source, span: range) -> Iterator[bytes]:
    """Yield all arrays of the scenarios of a span, scenario after scenario, `HASHED_AT_ONCE` scenarios at a time."""
    for first in range(span.start, span.stop, HASHED_AT_ONCE):
        numbers = first + np.arange(HASHED_AT_ONCE)
        scenarios, _ = source.take(numbers % len(source))  # always the same number, so that one program makes them all
        table = np.concatenate([_bytes(x) for x in jax.tree.leaves(scenarios)], axis=1)
        yield table[: span.stop - first].tobytes()


def _bytes(array: Array) -> np.ndarray:
    """Return the little-endian bytes of each episode, ``(episode, byte)``, of an array ``(..., episode)``."""
    episodes = np.asarray(array).T
    flat = np.ascontiguousarray(episodes.reshape(len(episodes), -1))
    return flat.astype(flat.dtype.newbyteorder("<")).view(np.uint8)
