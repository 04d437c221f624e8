"""The kinds of crossing, of contact and of leg: the only place that gives them numbers and names."""

from __future__ import annotations

from enum import IntEnum


class Kind(IntEnum):
    """A number in the simulator's arrays, and a word in files and reports."""

    @property
    def word(self) -> str:
        """The name as files and reports write it, such as ``jaywalk``."""
        return self.name.lower()


class CrossingKind(Kind):
    """How a pedestrian has decided to make its next (or current) crossing."""

    NONE = 0
    """Not decided yet."""
    CROSSWALK = 1
    JAYWALK = 2


class ContactKind(Kind):
    """What a pedestrian was doing when the car touched it."""

    NONE = 0
    """There was no contact."""
    CROSSWALK = 1
    JAYWALK = 2
    SIDEWALK = 3
    """It was on no roadway."""


class LegKind(Kind):
    """What a straight piece of a pedestrian's path is."""

    SIDEWALK = 0
    """An edge of the walking graph."""
    CROSSWALK = 1
    """Half a crosswalk, also an edge of the graph."""
    TO_ZONE = 2
    """The way to the point where a jaywalk begins."""
    ACROSS = 3
    """The jaywalk: across the roadway, in one line."""


NO_CROSSING, CROSSWALK, JAYWALK = CrossingKind
CONTACTS = tuple(ContactKind)[1:]
"""The kinds of contact, without NONE."""
