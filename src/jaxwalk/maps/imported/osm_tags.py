"""What OpenStreetMap's tags say of roads, crossings, parking and sidewalks. ``docs/real-streets.md`` has the rules.

The tags' meanings are those of the OpenStreetMap wiki (Key:lanes, Key:width, Key:maxspeed, Key:sidewalk,
Street parking, Key:crossing).
"""

from __future__ import annotations

import re
from typing import Literal, NamedTuple

from jaxwalk.maps.imported.source_map import Origin
from jaxwalk.maps.network import CrossingType

Tags = dict[str, str]
Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")


class RoadClass(NamedTuple):
    """What is assumed of roads of a class whose tags say nothing."""

    lane_width: float
    """[m]"""
    limit: float
    """[km/h]"""
    lanes: int
    """In each direction."""


CLASSES = {
    "trunk": RoadClass(3.5, 70, 2), "trunk_link": RoadClass(3.5, 50, 1),
    "primary": RoadClass(3.25, 50, 1), "primary_link": RoadClass(3.25, 50, 1),
    "secondary": RoadClass(3.25, 50, 1), "secondary_link": RoadClass(3.25, 50, 1),
    "tertiary": RoadClass(3.0, 50, 1), "tertiary_link": RoadClass(3.0, 50, 1),
    "unclassified": RoadClass(3.0, 50, 1), "residential": RoadClass(3.0, 30, 1),
    "living_street": RoadClass(2.75, 15, 1), "road": RoadClass(3.0, 50, 1),
}  # fmt: skip
"""The values of ``highway`` that are imported as roads."""
WALKS = ("footway", "path", "pedestrian", "steps", "corridor")
"""Values of ``highway`` on which people walk."""
LANE_WIDTHS = (2.5, 4.0)
"""Narrowest and widest lane [m]."""
MOST_LANES = 8
SPEEDS = (5.0, 130.0)
"""Lowest and highest speed limit [km/h]."""
MILE = 1.609344
PARKED_WIDTH = {"parallel": 2.0, "diagonal": 4.5, "perpendicular": 5.0}
"""Width of a strip by how vehicles stand in it [m]."""
RAISED = ("table", "hump", "raised_crossing")
"""Values of ``traffic_calming`` that raise a crossing."""
MARKED = ("zebra", "marked", "uncontrolled", "pelican", "toucan", "puffin", "pegasus")
"""Values of ``crossing`` for stripes; those of a British kind have signals too."""
SIGNALLED = ("traffic_signals", "pelican", "toucan", "puffin", "pegasus")


class LaneProfile(NamedTuple):
    """The lanes of a road, in the direction of its line."""

    forward: int
    backward: int
    lane_width: float
    """[m]"""
    limit: float
    """[m/s]"""

    @property
    def width(self) -> float:
        """The width of all lanes [m]."""
        return (self.forward + self.backward) * self.lane_width

    def turned(self) -> LaneProfile:
        """Return the profile for a line in the opposite direction."""
        return self._replace(forward=self.backward, backward=self.forward)

    def offset(self, forward: bool, number: int) -> float:
        """Return how far to the left of the road's middle a lane lies [m], counted from the leftmost of its direction.

        Traffic keeps right.
        """
        if forward:
            return -self.width / 2 + (self.forward - number - 0.5) * self.lane_width
        return self.width / 2 - (self.backward - number - 0.5) * self.lane_width


class RoadFacts(NamedTuple):
    """A road's profile, and where each number is from."""

    profile: LaneProfile
    lanes_from: Origin
    width_from: Origin
    limit_from: Origin


def is_road(tags: Tags) -> bool:
    """Return whether a way is imported as a road."""
    return tags.get("highway") in CLASSES and tags.get("area") != "yes" and tags.get("access") not in ("private", "no")


def road_facts(tags: Tags) -> RoadFacts:
    """Return the lanes of a road."""
    usual = CLASSES[tags["highway"]]
    forward, backward, lanes_from = _lanes(tags, usual)
    width, width_from = _lane_width(tags, forward + backward, usual)
    limit, limit_from = _limit(tags, usual)
    return RoadFacts(LaneProfile(forward, backward, width, limit), lanes_from, width_from, limit_from)


def one_way(tags: Tags) -> int:
    """Return 1 if traffic only follows the line of a way, -1 if it only goes against it, else 0."""
    said = tags.get("oneway")
    if said in ("-1", "reverse"):
        return -1
    around = tags.get("junction") in ("roundabout", "circular")
    return int(said in ("yes", "true", "1") or (around and said != "no"))


def _lanes(tags: Tags, usual: RoadClass) -> tuple[int, int, Origin]:
    """Return the number of lanes in both directions of the line, and where it is from."""
    whole, ahead, back = (_count(tags.get(key)) for key in ("lanes", "lanes:forward", "lanes:backward"))
    if way := one_way(tags):
        lanes = whole or ahead or back or usual.lanes
        origin: Origin = "mapped" if whole or ahead or back else "inferred"
        return (lanes, 0, origin) if way > 0 else (0, lanes, origin)
    if ahead and back:
        return ahead, back, "mapped"
    if whole and whole > 1:
        ahead = ahead if ahead and ahead < whole else whole - back if back and back < whole else -(-whole // 2)
        return ahead, whole - ahead, "mapped"
    return usual.lanes, usual.lanes, "inferred"


def _count(text: str | None) -> int | None:
    """Return a number of lanes, or None if the text is none."""
    number = _number(text)
    return int(min(number, MOST_LANES)) if number is not None and number >= 1 else None


def _number(text: str | None) -> float | None:
    found = re.match(r"\s*(\d{1,6}(?:[.,]\d{1,6})?)", text or "")
    return float(found[1].replace(",", ".")) if found else None


def metres(text: str | None) -> float | None:
    """Return a length [m] from a tag, such as ``3.5``, ``3.5 m`` or ``16'0"``; None if it is none."""
    number = _number(text)
    if number is None or not text:
        return None
    feet = re.match(r"\s*(\d{1,4})\s*'\s*(?:(\d{1,2})\s*\")?", text)
    if feet:
        return 0.3048 * (int(feet[1]) + int(feet[2] or 0) / 12)
    return number * 0.3048 if "ft" in text else number


def _lane_width(tags: Tags, lanes: int, usual: RoadClass) -> tuple[float, Origin]:
    """Return the width of a lane [m], and where it is from."""
    whole = metres(tags.get("width:carriageway")) or metres(tags.get("width")) or metres(tags.get("est_width"))
    if whole is None:
        return usual.lane_width, "inferred"
    parked = sum(on_road(tags, side) for side in SIDES)  # both widths include it
    low, high = LANE_WIDTHS
    return min(max((whole - parked) / lanes, low), high), "mapped"


def _limit(tags: Tags, usual: RoadClass) -> tuple[float, Origin]:
    """Return the speed limit [m/s], and where it is from."""
    said = tags.get("maxspeed", "")
    number = _number(said)
    if number is None:
        return usual.limit / 3.6, "inferred"
    low, high = SPEEDS
    return min(max(number * (MILE if "mph" in said else 1.0), low), high) / 3.6, "mapped"


def of_side(tags: Tags, key: str, side: Side) -> str | None:
    """Return what a key says of one side of a road: ``key:left`` before ``key:both`` before ``key``."""
    return tags.get(f"{key}:{side}") or tags.get(f"{key}:both") or tags.get(key)


def sidewalk(tags: Tags, side: Side) -> Literal["yes", "no", "unknown"]:
    """Return whether a side of a road has a sidewalk."""
    said = tags.get(f"sidewalk:{side}") or tags.get("sidewalk:both")
    if said is None:
        whole = tags.get("sidewalk") or tags.get("footway") or "unknown"
        said = (
            "yes" if whole in ("both", side, "yes", "separate") else "no" if whole in (*SIDES, "no", "none") else None
        )
    if said is None:
        return "unknown"
    return "no" if said in ("no", "none") else "yes"


def parked(tags: Tags, side: Side) -> tuple[float, bool] | None:
    """Return the width of a side's parking strip [m], and whether the roadway's width has it; None: nobody parks."""
    place = of_side(tags, "parking", side)
    stand = of_side(tags, "parking:orientation", side) or tags.get(f"parking:{side}:orientation")
    stand = stand or tags.get("parking:both:orientation")
    if place in ("lane", "street_side", "half_on_kerb", "on_kerb"):
        width = PARKED_WIDTH.get(stand or "parallel", 2.0)
        return (width / 2 if place == "half_on_kerb" else width), place in ("lane", "half_on_kerb")
    old = of_side(tags, "parking:lane", side)  # the scheme before 2022
    return (PARKED_WIDTH[old], True) if old in PARKED_WIDTH else None


def on_road(tags: Tags, side: Side) -> float:
    """Return how much of a road's mapped width a parking strip takes [m]."""
    strip = parked(tags, side)
    return strip[0] if strip is not None and strip[1] else 0.0


def crossing_kind(tags: Tags, way_tags: Tags) -> tuple[CrossingType, Origin] | None:
    """Return the kind of a crossing from the tags of its node and of the way that leads over it; None: nobody may."""
    said = [x for each in (tags, way_tags) for x in each.get("crossing", "").split(";") if x]
    if "no" in said[:1]:
        return None
    signals = any(x in SIGNALLED for x in said) or "yes" in (
        tags.get("crossing:signals"),
        way_tags.get("crossing:signals"),
    )
    markings = tags.get("crossing:markings") or way_tags.get("crossing:markings")
    if signals:
        return "signals", "mapped"
    marked = markings not in (None, "no") or any(x in MARKED for x in said) or "crossing_ref" in tags
    if any(x.get("traffic_calming") in RAISED for x in (tags, way_tags)) and (marked or not said):
        return "raised", "mapped"
    if marked and markings != "no":
        return "zebra", "mapped"
    if "unmarked" in said or markings == "no":
        return "unmarked", "mapped"
    return "unmarked", "inferred"
