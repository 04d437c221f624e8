"""Numbers that come in pieces: their sums, order statistics and counts, with one piece in memory at a time.

Each result is exact, and so the same however the numbers are divided.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain

import numpy as np
from jaxtyping import Float, Int, Shaped

DIGIT = 16
"""Number of bits of a value by which many values are divided at once."""
SORTED = 2**18
"""Most values that are sorted in memory."""


@dataclass(frozen=True)
class Values:
    """Numbers in pieces. Those whose order is asked for must not be NaN."""

    pieces: Callable[[], Iterable[Shaped[np.ndarray, "_"]]]
    """Returns the pieces, whenever it is called."""

    @staticmethod
    def of(values: Shaped[np.ndarray, "value"] | Values) -> Values:
        """Return an array as one piece."""
        return values if isinstance(values, Values) else Values(lambda: [values])

    def __iter__(self) -> Iterator[Shaped[np.ndarray, "_"]]:
        """Yield each piece."""
        return iter(self.pieces())

    def each(self, formula: Callable[[np.ndarray], np.ndarray]) -> Values:
        """Return what a formula makes of each piece."""
        return Values(lambda: map(formula, self.pieces()))

    @cached_property
    def count(self) -> int:
        """How many there are."""
        return sum(map(len, self))

    def sum(self) -> float:
        """Return the sum, rounded once."""
        return math.fsum(chain.from_iterable(piece.tolist() for piece in self))

    def ends(self) -> tuple[float, float]:
        """Return the smallest and the largest. Raise ValueError if there are none."""
        low, high = zip(*((piece.min(), piece.max()) for piece in self if len(piece)), strict=True)
        return float(min(low)), float(max(high))

    def ordered(self, ranks: Sequence[int]) -> list[float]:
        """Return the values at ranks of ascending order, from 0 on. Raise IndexError if there is none."""
        if ranks and not 0 <= min(ranks) <= max(ranks) < self.count:
            raise IndexError(f"{self.count} values have no ranks {list(ranks)}")
        found = _ordered(self, sorted({*ranks}), self.count, 64 - DIGIT)
        return [found[rank] for rank in ranks]

    def distinct(self) -> tuple[Float[np.ndarray, "different"], Int[np.ndarray, "different"]]:
        """Return the different values in ascending order, and how often each is there. All of them are in memory."""
        found, counts = np.zeros(0), np.zeros(0, np.int64)
        for piece in self:
            new, times = np.unique(piece.astype(np.float64), return_counts=True)
            found, place = np.unique(np.concatenate([found, new]), return_inverse=True)
            counts = np.bincount(place, np.concatenate([counts, times]), minlength=len(found)).astype(np.int64)
        return found, counts


def without_nan(values: Shaped[np.ndarray, "value"]) -> Shaped[np.ndarray, "_"]:
    """Return the values that aren't NaN."""
    return values[~np.isnan(values)]


def _ordered(values: Values, ranks: Sequence[int], count: int, shift: int) -> dict[int, float]:
    """Return the values at ranks; the bits of all ``count`` values are equal but for the last ``shift + DIGIT``."""
    if not ranks:
        return {}
    if count <= SORTED:
        return dict(zip(ranks, np.sort(np.concatenate([*values], dtype=np.float64))[[*ranks]].tolist(), strict=True))
    if shift < 0:
        return dict.fromkeys(ranks, values.ends()[0])
    until = np.cumsum(sum(np.bincount(_digit(piece, shift), minlength=1 << DIGIT) for piece in values))
    digits, found = np.searchsorted(until, ranks, side="right"), {}
    for digit in np.unique(digits).tolist():
        those = values.each(partial(_having, digit, shift))
        before = int(until[digit - 1]) if digit else 0
        within = [rank - before for rank in np.array(ranks)[digits == digit].tolist()]
        some = _ordered(those, within, int(until[digit]) - before, shift - DIGIT)
        found |= {rank + before: value for rank, value in some.items()}
    return found


def _digit(values: Shaped[np.ndarray, "value"], shift: int) -> Int[np.ndarray, "value"]:
    """Return `DIGIT` bits of each value, ``shift`` from the end, flipped so that they are in the order of values."""
    # the bits of positive floats, read as a whole number, are in their order, those of negative ones in the reverse one
    bits, top = (values.astype(np.float64) + 0.0).view(np.uint64), np.uint64(1 << 63)  # -0.0 + 0.0 is 0.0
    bits = np.where(bits & top, ~bits, bits | top)
    return (bits >> np.uint64(shift) & np.uint64((1 << DIGIT) - 1)).astype(np.int64)


def _having(digit: int, shift: int, values: Shaped[np.ndarray, "value"]) -> Shaped[np.ndarray, "_"]:
    return values[_digit(values, shift) == digit]
