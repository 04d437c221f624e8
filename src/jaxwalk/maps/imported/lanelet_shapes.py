"""The lanelets and areas of a Lanelet2 map as shapes: who may use them, their middle, their width, their ends."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.kerb_ground import surface
from jaxwalk.maps.imported.lanelet_reading import LaneletFile, LaneletRelation
from jaxwalk.maps.imported.osm_tags import Tags

Use = Literal["driven", "roadway", "beside", "walk", "crosswalk", "other"]
"""``driven``: cars drive there; ``roadway``: it is roadway on which nobody drives; ``beside``: it is roadway if it
lies along one; ``walk``: people walk there."""
USES: dict[str, Use] = {
    **dict.fromkeys(("road", "highway", "play_street"), "driven"),
    **dict.fromkeys(("bus_lane", "emergency_lane"), "roadway"),
    **dict.fromkeys(("bicycle_lane", "road_shoulder", "parking", "freespace", "keepout"), "beside"),
    **dict.fromkeys(("walkway", "shared_walkway", "sidewalk", "pedestrian_lane"), "walk"),
    "crosswalk": "crosswalk",
}
"""By the subtype of a lanelet or area."""
PARTICIPANT = "participant:"
"""How the keys begin of tags that say who may use a lanelet."""
YES, NO = ("yes", "true", "1"), ("no", "false", "0")
"""Values of tags that say yes or no."""
ONE_WAY = ("one_way", "one_way:vehicle", "one_way:vehicle:car")
"""Tags that say whether cars use a lanelet only from its beginning to its end, as they do where there is none."""
STEP = 1.0
"""Distance between the points of a lanelet's middle [m]."""
MOST_POINTS = 2000
"""Most points of a lanelet's middle."""
GRID = 0.1
"""Bounds end in one place if they do on this grid [m]."""
CLEAR = 0.8
"""To count, the votes for the other side, less those against it, must be at least this share of all."""
End = tuple[tuple[float, float], tuple[float, float]]


class LaneletShape(NamedTuple):
    """A lanelet."""

    number: int
    use: Use
    relation: LaneletRelation
    left: np.ndarray
    """Its left bound in the direction of travel (point, 2) [m]."""
    right: np.ndarray
    middle: np.ndarray
    """(point, 2) [m]"""
    width: float
    """Median along it [m]."""
    shape: BaseGeometry
    bounds: tuple[tuple[int, ...], tuple[int, ...]]
    """The numbers of the lines on its left and on its right."""

    @property
    def tags(self) -> Tags:
        """Its tags."""
        return self.relation.tags

    @property
    def name(self) -> str:
        """The name in the report."""
        return f"lanelet {self.number}"

    def end(self, which: int) -> End:
        """Return where its bounds begin (0) or end (-1), on a grid."""
        (x, y), (u, v) = ((np.round(line[which] / GRID) * GRID).tolist() for line in (self.left, self.right))
        return (x, y), (u, v)

    def turned(self) -> LaneletShape:
        """Return the lanelet in the other direction."""
        return self._replace(
            left=self.right[::-1], right=self.left[::-1], middle=self.middle[::-1], bounds=self.bounds[::-1]
        )

    def mirrored(self) -> LaneletShape:
        """Return the lanelet with x to the west; left and right are exchanged."""
        flip = np.array([-1.0, 1.0])
        return self._replace(
            left=self.right * flip, right=self.left * flip, middle=self.middle * flip, bounds=self.bounds[::-1],
            shape=shapely.transform(self.shape, lambda points: points * flip),
        )  # fmt: skip


class AreaShape(NamedTuple):
    """An area."""

    number: int
    subtype: str
    shape: BaseGeometry


def yes(tags: Tags, key: str) -> bool:
    """Return whether a tag says yes, in one of the format's words."""
    return tags.get(key) in YES


def use_of(tags: Tags) -> Use:
    """Return who uses a lanelet: by its subtype, unless tags say who may take part."""
    own: Use = USES.get(tags.get("subtype", "road"), "other")
    said = [key.removeprefix(PARTICIPANT) for key in tags if key.startswith(PARTICIPANT)]
    takes_part = [key for key in said if yes(tags, PARTICIPANT + key)]
    walks = own in ("crosswalk", "walk")
    if not said or (walks and ("pedestrian" in takes_part or (not takes_part and "pedestrian" not in said))):
        return own
    if any(key == "vehicle" or key.startswith("vehicle:car") for key in takes_part):
        return "driven"
    if any(key.startswith("vehicle") for key in takes_part):
        return "roadway"
    if "pedestrian" in takes_part:
        return "walk"
    return "beside" if "bicycle" in takes_part and own != "crosswalk" else "other"


def is_two_way(tags: Tags) -> bool:
    """Return whether cars use a lanelet in both directions."""
    said = next((tags[key] for key in ONE_WAY if key in tags), "yes")
    return said in NO


def lanelet_shapes(file: LaneletFile) -> tuple[list[LaneletShape], int]:
    """Return the lanelets of a file, and the number of those whose bounds the file doesn't have."""
    relations = [(n, x) for n, x in file.relations.items() if x.tags.get("type") == "lanelet"]
    found = [_shape(file, number, relation) for number, relation in relations]
    return [x for x in found if x is not None], sum(x is None for x in found)


def _shape(file: LaneletFile, number: int, relation: LaneletRelation) -> LaneletShape | None:
    sides = [tuple(relation.refs("way", role)) for role in ("left", "right")]
    bounds = [joined([file.lines[ref].points for ref in side if ref in file.lines]) for side in sides]
    if bounds[0] is None or bounds[1] is None or any(ref not in file.lines for side in sides for ref in side):
        return None
    left, right = _aligned(bounds[0], bounds[1])
    longest = max(shapely.LineString(line).length for line in (left, right))
    count = min(max(int(np.ceil(longest / STEP)), 1) + 1, MOST_POINTS)
    places = np.linspace(0.0, 1.0, count)
    one, other = (
        shapely.get_coordinates(shapely.LineString(line).interpolate(places, normalized=True)) for line in (left, right)
    )
    shape = surface(shapely.Polygon(np.concatenate([left, right[::-1]])))
    middle = (one + other) / 2
    if shape.is_empty or shapely.LineString(middle).length < GRID:
        return None
    bounding = shapely.LineString(left), shapely.LineString(right)
    points = shapely.points(middle)
    width = float(np.median(sum(shapely.distance(points, line) for line in bounding)))
    return LaneletShape(
        number, use_of(relation.tags), relation, left, right, middle, width, shape, (sides[0], sides[1])
    )


def joined(lines: Sequence[np.ndarray]) -> np.ndarray | None:
    """Return lines (point, 2) one after the other, each turned so that it begins where the one before ends."""
    if not lines:
        return None
    whole = lines[0]
    for line in lines[1:]:
        gaps = {
            (a, b): float(np.hypot(*(whole[a] - line[b]))) for a in (-1, 0) for b in (0, -1)
        }  # fmt: skip
        a, b = min(gaps, key=lambda pair: gaps[pair])
        whole = whole if a == -1 else whole[::-1]
        whole = np.concatenate([whole, line if b == 0 else line[::-1]])
    keep = np.concatenate([[True], np.hypot(*np.diff(whole, axis=0).T) > 1e-6])
    return whole[keep] if keep.sum() > 1 else None


def _aligned(left: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two bounds in the direction of travel: the lines may be stored in any direction."""
    turned = right[::-1]
    apart, crossed = (np.hypot(*(left[[0, -1]] - x[[0, -1]]).T).sum() for x in (right, turned))
    is_valid = [shapely.Polygon(np.concatenate([left, x[::-1]])).is_valid for x in (right, turned)]
    right = turned if (is_valid == [False, True] or (is_valid[0] == is_valid[1] and crossed < apart)) else right
    x, y = np.concatenate([left, right[::-1]]).T
    area = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    return (left[::-1], right[::-1]) if area > 0 else (left, right)


def area_shapes(file: LaneletFile) -> tuple[list[AreaShape], int]:
    """Return the areas of a file, and the number of those whose outline the file doesn't have, or not whole."""
    relations = [(n, x) for n, x in file.relations.items() if x.tags.get("type") in ("multipolygon", "area")]
    found = [(n, x.tags.get("subtype", ""), _outlined(file, x)) for n, x in relations]
    return [AreaShape(n, kind, x) for n, kind, x in found if not x.is_empty], sum(x.is_empty for *_, x in found)


def _outlined(file: LaneletFile, relation: LaneletRelation) -> BaseGeometry:
    """Return an area's shape, less its holes; empty where a line of its outline is missing."""
    refs = relation.refs("way", "outer")
    outline = joined([file.lines[ref].points for ref in refs]) if all(ref in file.lines for ref in refs) else None
    if outline is None or len(outline) < 3:
        return shapely.Polygon()
    inner = [shapely.LineString(file.lines[ref].points) for ref in relation.refs("way", "inner") if ref in file.lines]
    return surface(shapely.Polygon(outline)).difference(shapely.polygonize(inner))


def keeps_left(lanelets: Sequence[LaneletShape]) -> bool | None:
    """Return whether traffic keeps left, by lanelets of opposite directions side by side; None if none are."""
    at: dict[int, list[tuple[int, LaneletShape]]] = defaultdict(list)
    for lanelet in lanelets:
        for ref, side in [(ref, side) for side, refs in enumerate(lanelet.bounds) for ref in refs]:
            at[ref].append((side, lanelet))
    pairs = [own for own in at.values() if len(own) == 2 and own[0][0] == own[1][0]]
    votes = [1 if side else -1 for (side, one), (_, other) in pairs if _ahead(one) @ _ahead(other) < 0]
    return None if abs(sum(votes)) < max(CLEAR * len(votes), 1) else sum(votes) > 0


def _ahead(lanelet: LaneletShape) -> np.ndarray:
    return lanelet.middle[-1] - lanelet.middle[0]


def beside(shapes: Sequence[tuple[int, BaseGeometry, float]], roadway: BaseGeometry) -> set[int]:
    """Return the numbers of shapes that touch a roadway for a length of their own [m]."""
    near = roadway.buffer(GRID)
    shapely.prepare(near)
    return {n for n, shape, shortest in shapes if near.intersection(shape.boundary).length > shortest}
