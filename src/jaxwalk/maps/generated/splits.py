"""Which numbers are for training, validation and test. They never meet; ``docs/streets.md`` says why they are these."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from jaxwalk.maps.generated.refusal import Refusal
from jaxwalk.maps.generated.town import ARTERIAL, PARKED, TOWN, UNSEEN, Town

if TYPE_CHECKING:
    from jaxwalk.maps.generated.town_street import TownStreet


@dataclass(frozen=True)
class Split:
    """Numbers of a family's streets."""

    name: str
    family: Town
    numbers: range

    def streets(self, refused: Counter[str] | None = None) -> Iterator[TownStreet]:
        """Yield the streets of this split in the order of their numbers, without those that are refused.

        Args:
            refused: counts the refused numbers by reason; None: they aren't counted.
        """
        for number in self.numbers:
            street = self.street(number, refused)
            if street is not None:
                yield street

    def street(self, number: int, refused: Counter[str] | None = None) -> TownStreet | None:
        """Return the street of a number, or None, with its reason counted, if the number is refused."""
        from jaxwalk.maps.generated.town_street import make_street  # here: every command's options list the splits

        try:
            return make_street(self.family, number)
        except Refusal as refusal:
            if refused is not None:
                refused[str(refusal)] += 1
            return None


SPLITS = {
    split.name: split
    for split in (
        Split("training", TOWN, range(0, 10**9)),
        Split("validation", TOWN, range(10**9, 10**9 + 10**6)),
        Split("test", TOWN, range(2 * 10**9, 2 * 10**9 + 10**6)),
        Split("unseen-ranges", UNSEEN, range(3 * 10**9, 3 * 10**9 + 10**6)),
        Split("arterial", ARTERIAL, range(4 * 10**9, 4 * 10**9 + 10**6)),
        Split("parked-test", PARKED, range(5 * 10**9, 5 * 10**9 + 10**6)),
        Split("parked-training", PARKED, range(6 * 10**9, 6 * 10**9 + 10**6)),
    )
}
"""The splits by name. They are fixed: a street that was trained on must never be one of a test."""
