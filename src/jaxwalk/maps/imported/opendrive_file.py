"""OpenDRIVE files (.xodr) before netconvert reads them: what it would misread is refused, or written otherwise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, ParseError, parse, tostring

import numpy as np

from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.xml_safety import refuse_declarations

MOST_BYTES = 40_000_000
"""Largest file [bytes]."""
CROSSWALK = "crosswalk"
"""The type of an object over which people cross. CARLA writes it into the name, and -1 as the type."""


class DriveFile(NamedTuple):
    """A file for netconvert, and what that leaves out."""

    text: bytes
    crosswalks: dict[str, str]
    """By their ids in ``text``: the ids of the object and its road in the file, in words."""
    lane_types: tuple[str, ...]


def opendrive_file(path: Path) -> DriveFile:
    """Return an OpenDRIVE file without place on earth, and whose only objects are crosswalks with length and width.

    Raises ImportRefusal if it can't be read, is too large, or has traffic that keeps left.
    """
    if path.stat().st_size > MOST_BYTES:
        raise ImportRefusal(f"{path}: larger than {MOST_BYTES:,} bytes; cut a part out")
    refuse_declarations(path)
    try:
        root = parse(path).getroot()
    except (ParseError, ValueError, LookupError) as error:
        raise ImportRefusal(f"{path}: not XML that can be read ({error}); export it again") from None
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]  # netconvert knows the names without their space
    if root.tag != "OpenDRIVE":
        raise ImportRefusal(f"{path}: begins with <{root.tag}>, not with <OpenDRIVE>; name an OpenDRIVE file")
    left = [road for road in root.iter("road") if road.get("rule", "RHT") != "RHT"]
    if left:
        raise ImportRefusal(f"{path}: traffic keeps left on road {left[0].get('id')} (rule=\"LHT\"), which isn't read "
                            "from OpenDRIVE; make a SUMO network of it")  # fmt: skip
    for header in root.iter("header"):
        _remove(header, "geoReference")  # else netconvert writes degrees, with 0.1 m
    try:
        crosswalks = dict(_crosswalks(root))
    except ValueError as error:
        raise ImportRefusal(f"{path}: a crosswalk isn't as the format has it ({error}); export it again") from None
    types = sorted({lane.get("type", "") for lane in root.iter("lane")})
    return DriveFile(tostring(root), crosswalks, tuple(types))


def _remove(element: Element, *tags: str) -> None:
    for child in [child for child in element if child.tag in tags]:
        element.remove(child)


def _crosswalks(root: Element) -> Iterator[tuple[str, str]]:
    """Leave only crosswalks among the objects of all roads, and yield their new ids and where they are from."""
    seen: Counter[str] = Counter()
    everything = [(road, objects, thing) for road in root.iter("road") for objects in road.iter("objects")
                  for thing in list(objects)]  # fmt: skip
    for road, objects, thing in everything:
        if thing.tag != "object" or not _is_crosswalk(thing):
            objects.remove(thing)
            continue
        name = f"crosswalk {thing.get('id')} of road {road.get('id')}"
        seen[name] += 1
        name += f" ({seen[name]})" if seen[name] > 1 else ""
        thing.attrib |= {"id": f"crosswalk {seen.total()}", **_box(thing)}
        _remove(thing, *{child.tag for child in thing})
        yield thing.attrib["id"], name


def _is_crosswalk(thing: Element) -> bool:
    kind = thing.get("type", "").lower()
    return kind == CROSSWALK or (kind in ("-1", "none", "") and CROSSWALK in thing.get("name", "").lower())


def _box(thing: Element) -> dict[str, str]:
    """Return the attributes of the rectangle around a crosswalk's outline; none if it has a length and a width."""
    length, width = (float(thing.get(name, "0")) for name in ("length", "width"))
    local = np.array([(_number(x, "u"), _number(x, "v")) for x in thing.iter("cornerLocal")]).reshape(-1, 2)
    on_road = np.array([(_number(x, "s"), _number(x, "t")) for x in thing.iter("cornerRoad")]).reshape(-1, 2)
    if (length > 0 and width > 0) or not len(local) + len(on_road):
        return {}
    corners = on_road if len(on_road) else local
    (along, aside), (length, width) = (corners.min(axis=0) + corners.max(axis=0)) / 2, np.ptp(corners, axis=0)
    if len(on_road):
        return {"s": f"{along}", "t": f"{aside}", "hdg": "0", "length": f"{length}", "width": f"{width}"}
    angle = float(thing.get("hdg", "0"))
    ahead, left = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    s, t = np.array([_number(thing, "s"), _number(thing, "t")]) + along * ahead + aside * left
    return {"s": f"{s}", "t": f"{t}", "length": f"{length}", "width": f"{width}"}


def _number(element: Element, name: str) -> float:
    """Return an attribute as a number. Raise ValueError if it is none."""
    number = float(element.get(name, "nan"))
    if not np.isfinite(number):
        raise ValueError(f"{name} of <{element.tag}>: {element.get(name)}")
    return number
