"""Names of generated streets, which stand where maps are named.

``test-2000000003`` is the street of a number of the split ``test``; ``test:20`` stands for its first 20 streets.
"""

from __future__ import annotations

import re
from functools import lru_cache
from itertools import islice

from jaxwalk.maps.file import MapError
from jaxwalk.maps.generated.refusal import Refusal
from jaxwalk.maps.generated.splits import SPLITS, Split
from jaxwalk.maps.generated.town_street import make_street
from jaxwalk.maps.network_file import network_text

MOST_STREETS = 1000
"""Most streets that a name stands for."""
FORMS = f"SPLIT:COUNT or SPLIT-NUMBER, where SPLIT is one of {', '.join(SPLITS)}"

_NAME = re.compile(f"({'|'.join(SPLITS)})([:-])([0-9]{{1,12}})")


def names_generated(name: str) -> bool:
    """Return whether a name is that of a generated street, or stands for several."""
    return _NAME.fullmatch(name) is not None


def each_name(name: str) -> tuple[str, ...]:
    """Return the names of all streets that a name stands for, in the order of their numbers; another name alone.

    Raises MapError for a count that isn't from 1 to `MOST_STREETS`.
    """
    found = _NAME.fullmatch(name)
    if found is None or found[2] == "-":
        return (name,)
    count = int(found[3])
    if not 1 <= count <= MOST_STREETS:
        raise MapError(name, [f"the number of streets must lie in [1, {MOST_STREETS:,}], not {count:,}"])
    return _first_names(SPLITS[found[1]], count)


@lru_cache
def _first_names(split: Split, count: int) -> tuple[str, ...]:
    made = (number for number in split.numbers if not isinstance(_made(split.name, number), Refusal))
    return tuple(f"{split.name}-{number}" for number in islice(made, count))


def generated_text(name: str) -> str:
    """Return a generated street as the text of a network's file. ``name`` names one street.

    Raises MapError if the number isn't one of the split's, or gives no street.
    """
    found = _NAME.fullmatch(name)
    if found is None or found[2] == ":":
        raise MapError(name, ["stands for several streets: name one, as SPLIT-NUMBER"])
    split, number = SPLITS[found[1]], int(found[3])
    if number not in split.numbers:
        first, last = split.numbers[0], split.numbers[-1]
        raise MapError(name, [f"the numbers of {split.name} are {first} to {last}: choose one of them"])
    made = _made(split.name, number)
    if isinstance(made, Refusal):
        raise MapError(name, [f"this number gives no street ({made}): choose another one"])
    return made


@lru_cache(maxsize=MOST_STREETS)
def _made(split: str, number: int) -> str | Refusal:
    """Return a street's text, or why the number gives none. Kept, because a name is read several times."""
    try:
        return network_text(make_street(SPLITS[split].family, number).network)
    except Refusal as refusal:
        return refusal
