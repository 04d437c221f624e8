"""Kinds of people: in which shares they are there, how often they jaywalk, and how fast they are.

This module imports no JAX.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Any

Pace = tuple[float, float]
"""Speeds of the slowest and of the fastest person [m/s]."""
FASTEST = 20.0
"""Highest speed of people [m/s]."""
ROUNDING = 1e-6
"""The sum of the shares may differ from 1 by this."""


@dataclass(frozen=True)
class PersonKind:
    """People of one kind. An impossible number raises ValueError, which names the field."""

    name: str
    share: float
    """Share of the people."""
    tendency: float
    """Jaywalking tendency (tau of equation 1), the same for all of them."""
    walk: Pace | None = None
    """How fast they walk [m/s]: whoever has a second trait of 0, and whoever has 1. None: as the world says."""
    jaywalk: Pace | None = None
    """How fast they are on the way across on a jaywalk [m/s]; None: as they walk."""

    def __post_init__(self) -> None:
        """Refuse an impossible share, tendency or speed."""
        if not 0 < self.share <= 1:
            raise ValueError(f"kinds: the share of {self.name!r} must be above 0 and at most 1, not {self.share}")
        if not 0 <= self.tendency <= 1:
            raise ValueError(f"kinds: the tendency of {self.name!r} must lie in [0, 1], not {self.tendency}")
        for field in ("walk", "jaywalk"):
            pace = getattr(self, field)
            if pace is not None and not 0 < pace[0] <= pace[1] <= FASTEST:
                at_most = f"above 0, at most {FASTEST:g} m/s, and the second one no lower"
                raise ValueError(f"kinds: both speeds of {field} of {self.name!r} must be {at_most}, not {pace}")


# Every kind has the share 1 here: `in_shares` gives each its own.
CALM = PersonKind("calm", 1.0, tendency=0.02)
"""People who hardly ever jaywalk; our choice."""
HURRIED = PersonKind("hurried", 1.0, tendency=0.9, jaywalk=(2.2, 3.0))
"""People who run over the road on a jaywalk; our choice."""
RUNNER = PersonKind("runner", 1.0, tendency=0.3, walk=(2.22, 3.5))
"""People who run everywhere. 2.22 m/s is the running adult of Euro NCAP's test CPFA and of FMVSS 127 (8 km/h); the
rest is our choice."""
CHILD = PersonKind("child", 1.0, tendency=0.5, walk=(0.83, 1.39), jaywalk=(2.22, 3.0))
"""Children: they walk slower than adults, and run on a jaywalk. 1.39 m/s is the child of Euro NCAP's test CPNCO
(5 km/h) and 0.83 m/s its slow walker (3 km/h), 2.22 m/s the protocols' runner; the rest is our choice."""
CAMPUS = PersonKind("campus", 1.0, tendency=0.5, walk=(0.89, 1.66))
"""People of a real crosswalk on a campus: their pace is fitted to every second clip of it, by
``docs/real_recordings_calibration.py``. The tendency is the mean of the paper's, not measured."""
KINDS = {kind.name: kind for kind in (CALM, HURRIED, RUNNER, CHILD, CAMPUS)}
"""The kinds that have a name."""


def in_shares(**shares: float) -> tuple[PersonKind, ...]:
    """Return the named kinds (`KINDS`) in these shares, as in ``in_shares(calm=0.9, runner=0.1)``.

    Raise ValueError for a name that doesn't exist, or an impossible share.
    """
    for name in shares:
        if name not in KINDS:
            raise ValueError(f"no kind {name!r} of people; there are: {', '.join(KINDS)}")
    return tuple(replace(KINDS[name], share=share) for name, share in shares.items())


def begins(kinds: Sequence[PersonKind]) -> tuple[float, ...]:
    """Return the first trait at which each kind begins; kinds follow each other, each as wide as its share."""
    return tuple(accumulate((kind.share for kind in kinds[:-1]), initial=0.0))


def check_kinds(kinds: Sequence[PersonKind]) -> None:
    """Raise ValueError unless the shares of the kinds are 1 together, and each has a name of its own."""
    total = sum(kind.share for kind in kinds)
    if kinds and abs(total - 1) > ROUNDING:
        raise ValueError(f"kinds: the shares are {total:g} together, not 1; change one, or add a kind")
    names = [kind.name for kind in kinds]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"kinds: there are two kinds {name!r}; name each once")


def with_kinds(document: Any) -> Any:
    """Return the rules read from a file, with kinds of people as tuples, as pydantic's strict mode wants them.

    Files from before there were kinds have fields about people in a hurry instead.
    """
    if not isinstance(document, dict):
        return document
    share, often, seldom, *pace = (document.get(name, usual) for name, usual in OF_HURRY.items())
    kinds = document.get("kinds", ())
    if "hurried" in document and isinstance(share, (int, float)):
        calm = {"name": CALM.name, "share": 1 - share, "tendency": seldom}
        hurried = {"name": HURRIED.name, "share": share, "tendency": often, "jaywalk": pace}
        kinds = [kind for kind in (calm, hurried) if share and kind["share"]]
        document = {name: value for name, value in document.items() if name not in OF_HURRY}
    return {**document, "kinds": _as_tuples(kinds)}


OF_HURRY = {
    "hurried": 0.0, "hurried_tendency": 0.9, "other_tendency": 0.02, "slowest_hurry": 2.2, "fastest_hurry": 3.0,
}  # fmt: skip
"""Fields of files from before there were kinds, and what they were unless said."""


def _as_tuples(value: Any) -> Any:
    """Return lists as tuples, also those in dicts."""
    if isinstance(value, dict):
        return {name: _as_tuples(one) for name, one in value.items()}
    return tuple(map(_as_tuples, value)) if isinstance(value, list) else value
