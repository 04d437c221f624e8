"""What Lanelet2 maps say of speed limits and crosswalks: by tags, traffic signs, traffic lights and markings."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.lanelet_reading import LaneletFile, LaneletRelation
from jaxwalk.maps.imported.lanelet_shapes import LaneletShape, yes
from jaxwalk.maps.imported.osm_tags import MILE
from jaxwalk.maps.imported.source_map import Origin, SourceCrossing
from jaxwalk.maps.network import CrossingType

SPEEDS = (6.0, 130.0)
"""Lowest and highest speed limit [km/h]."""
URBAN, NONURBAN, PLAY = 50.0, 100.0, 15.0
"""Speed limits where the map says nothing [km/h]."""
UNITS = {"": 1.0, "km/h": 1.0, "kmh": 1.0, "kph": 1.0, "mph": MILE, "mps": 3.6, "m/s": 3.6}
"""In km/h, which is the unit where none is named."""
NUMBER = re.compile(r"\s*(\d+(?:\.\d*)?)\s*([a-z/]*)\s*")
"""A speed with its unit."""
SIGN = re.compile(r"de274(?:[._]1(?!\d))?(?:[^0-9]+(\d{1,3}))?")
"""The German sign of a speed limit, 274, and of a zone of one, 274.1: of 30 km/h unless a number follows."""
SIGN_OF_TOWN = "de310"
"""The German sign at which a town begins."""
SPEED_TAGS = ("speed_limit:vehicle:car", "speed_limit:vehicle", "speed_limit")
"""Tags of a lanelet's speed limit: the finest one that there is counts."""
CROSSING_WIDTHS = (2.0, 8.0)
NEAR_LIGHTS = 10.0
"""A crosswalk this close to where cars stop for a traffic light has one [m]."""
SHORTEST = 1.0
"""Fewer metres of roadway on the way over a crosswalk are none [m]."""


class CrosswalkRules(NamedTuple):
    """What a map's crosswalks are judged by."""

    file: LaneletFile
    stops: BaseGeometry
    """Where cars stop for traffic lights."""


def limit_of(file: LaneletFile, lanelet: LaneletShape) -> tuple[float, Origin]:
    """Return a speed limit [km/h], and where it is from: a rule before a tag before what is usual.

    A rule's sign counts before its ``sign_type``; rules that hold only at times (``dynamic``) don't count. A limit
    beyond `SPEEDS` is moved there, and so is inferred.
    """
    rules = [x for x in _rules(file, lanelet) if x.tags.get("subtype") == "speed_limit" and not yes(x.tags, "dynamic")]
    said = [text for rule in rules for text in _signs(file, rule)] + [lanelet.tags.get(key, "") for key in SPEED_TAGS]
    number = next((number for text in said if (number := _speed(text)) is not None), None)
    if number is not None:
        return float(np.clip(number, *SPEEDS)), "mapped" if SPEEDS[0] <= number <= SPEEDS[1] else "inferred"
    if lanelet.tags.get("subtype") == "play_street":
        return PLAY, "inferred"
    return (NONURBAN if lanelet.tags.get("location") == "nonurban" else URBAN), "inferred"


def _signs(file: LaneletFile, rule: LaneletRelation) -> list[str]:
    """Return what a rule of speed says."""
    signs = [file.lines[ref].tags.get("subtype", "") for ref in rule.refs("way", "refers") if ref in file.lines]
    return [*signs, rule.tags.get("sign_type", "")]


def _rules(file: LaneletFile, lanelet: LaneletShape) -> Iterator[LaneletRelation]:
    """Yield the rules that a lanelet names."""
    refs = lanelet.relation.refs("relation")
    yield from (file.relations[ref] for ref in refs if ref in file.relations)


def _speed(text: str) -> float | None:
    """Return a speed [km/h] from a tag or a sign's name; None if it is none, is 0, or has a unit that nobody knows."""
    if text.lower() == SIGN_OF_TOWN:
        return URBAN
    if sign := SIGN.fullmatch(text.lower()):
        return float(sign[1] or 30)
    found = NUMBER.fullmatch(text.lower())
    speed = float(found[1]) * UNITS.get(found[2], 0.0) if found else 0.0
    return speed or None


def crosswalk_rules(file: LaneletFile, lanelets: Sequence[LaneletShape], flip: float) -> CrosswalkRules:
    """Return what crosswalks are judged by; ``flip`` is -1 if x counts to the west."""
    stops: list[BaseGeometry] = []
    for lanelet in (x for x in lanelets if x.use == "driven"):
        for rule in (x for x in _rules(file, lanelet) if x.tags.get("subtype") == "traffic_light"):
            lines = [file.lines[ref].points * (flip, 1.0) for ref in rule.refs("way", "ref_line") if ref in file.lines]
            stops += [shapely.LineString(line) for line in lines] or [shapely.Point(lanelet.middle[-1])]
    return CrosswalkRules(file, shapely.union_all(stops))


def crossing_of(rules: CrosswalkRules, lanelet: LaneletShape, roadway: BaseGeometry) -> SourceCrossing | None:
    """Return the crossing of a crosswalk, in the middle of its longest way over a roadway; None if it has none."""
    over = shapely.get_parts(shapely.LineString(lanelet.middle).intersection(roadway)).tolist()
    longest = max((x for x in over if x.length >= SHORTEST), key=lambda x: x.length, default=None)
    if longest is None:
        return None
    point = shapely.get_coordinates(longest.interpolate(0.5, normalized=True))[0]
    ahead = lanelet.middle[-1] - lanelet.middle[0]
    kind, origin = _kind(rules, lanelet)
    width = float(np.clip(lanelet.width, *CROSSING_WIDTHS))
    return SourceCrossing(lanelet.name, kind, point, ahead / np.hypot(*ahead), origin, width)


def _kind(rules: CrosswalkRules, lanelet: LaneletShape) -> tuple[CrossingType, Origin]:
    """Return the kind of a crosswalk, and where that is from."""
    if any(rule.tags.get("subtype") == "traffic_light" for rule in _rules(rules.file, lanelet)):
        return "signals", "mapped"
    if rules.stops.distance(lanelet.shape) < NEAR_LIGHTS:
        return "signals", "inferred"
    lines = [rules.file.lines[ref].tags.get("type") for side in lanelet.bounds for ref in side]
    if "zebra_marking" in lines:
        return "zebra", "mapped"
    return ("unmarked", "mapped") if "pedestrian_marking" in lines else ("zebra", "inferred")
