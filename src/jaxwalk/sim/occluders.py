"""Which parked vehicles and buildings can come between the car and somebody, for each place of the car.

A step can't look at every box of a street. So each cell of the ground has a row with those that lie on some line from
the car there to a place where people may be, within the range of sight.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from jaxtyping import Bool, Float, Shaped

from jaxwalk.maps import RoadMap
from jaxwalk.maps.parking_slots import SLOT_COLUMNS
from jaxwalk.maps.road_field import BEYOND, UNIT
from jaxwalk.maps.road_field import CELL as FIELD_CELL
from jaxwalk.maps.tables import rounded_up

CELL = 8.0
"""Side of a cell of the ground [m]."""
COLUMNS = (*SLOT_COLUMNS, "slot")
"""The columns of an occluder: its box, and its parking slot, `NO_SLOT` for a building."""
NO_SLOT, PADDING = -1.0, -2.0
LANES = 8
"""Boxes that a step looks at in one turn: as many numbers of single precision as 256 bits hold."""
ENTRIES = 3 * LANES
"""The boxes of a cell are padded to a multiple of this number. The rows of the tables compete for the same places of a
cache, and take 1.3 times as long, if their size is a power of two."""
EYES, TARGETS = 2.0, 2.0
"""Distances between the places of the eye and between those of people that are tried [m]."""
WIDENED = 1.5
"""Boxes are widened by this [m]. No place is farther from a tried one (1.42 m), and so no line from a tried line: none
of the boxes between tried lines is missed."""
BESIDE = 3.0
"""The eye is less than half of this beyond the roadway's edge, so a tried place is near it [m]."""
AT_ONCE = 2_000_000
"""Boxes times places that a thread looks at at once."""
EYES_APART, PLACES_APART = 6, 8
"""Every box is tried with the lines from each sixth eye of a cell to each eighth place."""
ROUNDING = 0.01
"""More than single precision loses [m]."""


def pack_occluders(maps: RoadMap, sight: float) -> tuple[Float[np.ndarray, "map row column box"], ...]:
    """Return the occluders of each cell, a table for each of `COLUMNS`; ``maps`` are stacked NumPy arrays.

    The first row and column lie at the map's south-western corner. ``sight`` is the range of sight [m].
    """
    shape = tuple(rounded_up(int(np.ceil(float(np.max(extent)) / CELL)) + 1) for extent in (maps.height, maps.width))
    copies = [number for number in range(1, len(maps.width)) if _is_the_first(maps, number)]
    different = sorted({*range(len(maps.width))} - {*copies})
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        each = threads.map(lambda number: list(_of_map(maps, number, shape, sight)), different)
        cells = {cell: boxes for cells_of_map in each for cell, boxes in cells_of_map}
    most = ENTRIES * -(-max([1, *map(len, cells.values())]) // ENTRIES)
    packed = np.zeros((len(COLUMNS), len(maps.width), *shape, most), np.float32)
    packed[-1] = PADDING
    for cell, boxes in cells.items():
        packed[(slice(None), *cell, slice(len(boxes)))] = boxes.T
    packed[:, copies] = packed[:, :1]
    return tuple(packed)


def _is_the_first(maps: RoadMap, number: int) -> bool:
    """Return whether a map is the first one again, as those are that fill up a stack."""
    return all((table[number] == table[0]).all() for table in vars(maps).values())


def blocked(
    boxes: Shaped[np.ndarray, "... 6"], eye: Shaped[np.ndarray, "... 2"], to: Shaped[np.ndarray, "... 2"]
) -> Bool[np.ndarray, "..."]:
    """Return whether a line from ``eye`` to ``to`` meets a box; the leading axes broadcast.

    By separating axes (Gottschalk, Lin and Manocha 1996), without division: a line and a box are apart if their
    shadows on one of the box's two directions, or across the line, are apart.
    """
    x, y, cos, sin, half_length, half_width = np.moveaxis(boxes, -1, 0)
    (dx, dy), (px, py) = np.moveaxis(to - eye, -1, 0), np.moveaxis(eye, -1, 0)
    along, left = dx * cos + dy * sin, dy * cos - dx * sin
    ahead, aside = (x - px) * cos + (y - py) * sin, (y - py) * cos - (x - px) * sin
    return meets(along, left, ahead, aside, half_length, half_width)


def meets(along, left, ahead, aside, half_length, half_width):
    """Return whether lines from (0, 0) meet boxes, in the boxes' own directions [m]. Also for JAX arrays.

    Args:
        along: where the lines end, along the boxes.
        left: the same, to the left.
        ahead: where the boxes' centres are, along the boxes.
        aside: the same, to the left.
        half_length: half the boxes' lengths.
        half_width: half the boxes' widths.
    """
    return (
        (abs(along / 2 - ahead) <= half_length + abs(along) / 2)
        & (abs(left / 2 - aside) <= half_width + abs(left) / 2)
        & (abs(ahead * left - aside * along) <= half_length * abs(left) + half_width * abs(along))
    )


def _of_map(
    maps: RoadMap, number: int, shape: tuple[int, ...], sight: float
) -> Iterator[tuple[tuple[int, int, int], np.ndarray]]:
    """Yield the cells of a map where the car may be, as (map, row, column), with their boxes, (box, column)."""
    slots, walls = (
        np.asarray(table[number])[: int(count[number])]
        for table, count in ((maps.slots, maps.slot_count), (maps.walls, maps.wall_count))
    )
    boxes = np.concatenate([np.column_stack([slots, np.arange(len(slots))]),
                            np.column_stack([walls, np.full(len(walls), NO_SLOT)])])  # fmt: skip
    roadway, people = _places(maps, number)
    around = np.stack(np.meshgrid([-EYES, 0, EYES], [-EYES, 0, EYES]), -1).reshape(-1, 2)
    cells = np.unique(((roadway[:, None] + around) // CELL).astype(int).reshape(-1, 2), axis=0)
    for column, row in cells[(cells >= 0).all(axis=1) & (cells < shape[::-1]).all(axis=1)].tolist():
        beyond = np.abs(roadway - (np.array([column, row]) + 0.5) * CELL) - CELL / 2
        eyes = roadway[(beyond <= EYES).all(axis=1)]
        yield (number, row, column), boxes[_matter(boxes, eyes, people, sight)]


def _matter(boxes: np.ndarray, eyes: np.ndarray, people: np.ndarray, sight: float) -> Bool[np.ndarray, " box"]:
    """Return which boxes, widened, lie on a line from one of the eyes to one of the places of people."""
    middle, spread = eyes.mean(axis=0), 2 * CELL
    reach = np.hypot(*(boxes[:, :2] - middle).T) - np.hypot(boxes[:, 4], boxes[:, 5]) <= sight + spread
    near = people[np.hypot(*(people - middle).T) <= sight + spread]
    wide = boxes[:, :6] + np.array([0, 0, 0, 0, WIDENED, WIDENED])
    wide, eyes, near = (of.astype(np.float32) for of in (wide, eyes, near))
    matter, reached = np.zeros(len(boxes), bool), np.flatnonzero(reach)
    for part in np.array_split(reached, 1 + len(reached) * len(near) // AT_ONCE):
        matter[part] = _on_lines(wide[part], eyes, near)
    return matter


def _on_lines(boxes: np.ndarray, eyes: np.ndarray, places: np.ndarray) -> Bool[np.ndarray, " box"]:
    """Return which boxes (box, 6) lie on a line from an eye (eye, 2) to a place (place, 2) [m].

    All lines are tried only with the boxes that none of a few lines meets.
    """
    middle = eyes.mean(axis=0, keepdims=True)
    begin, centre, end = (_in_frames(boxes, points) for points in (eyes, middle, places))
    half = boxes[:, 4:].T[..., None]
    on_few = _between(begin[:, :, ::EYES_APART, None], end[:, :, None, ::PLACES_APART], half[..., None])
    found = np.asarray(on_few.any(axis=(1, 2)))
    rest = np.flatnonzero(~found)
    # no point of a line from an eye is farther than this from the line from the middle to the same place
    farthest = np.hypot(*(eyes - middle).T).max() + np.float32(ROUNDING)
    which, place = np.nonzero(_between(centre[:, rest], end[:, rest], half[:, rest] + farthest))
    box = rest[which]
    eyes_first = begin.swapaxes(1, 2).take(box, axis=2)  # the long axis comes last, which is quicker
    found[box[_between(eyes_first, end[:, None, box, place], half[:, None, box, 0]).any(axis=0)]] = True
    return found


def _in_frames(boxes: np.ndarray, points: np.ndarray) -> Float[np.ndarray, "2 box point"]:
    """Return where points (point, 2) are from the boxes' centres, along the boxes and to the left."""
    x, y, cos, sin = boxes[:, :4].T
    directions = np.stack([np.stack([cos, sin], axis=-1), np.stack([-sin, cos], axis=-1)])
    return directions @ points.T - np.stack([x * cos + y * sin, y * cos - x * sin])[..., None]


def _between(begin: np.ndarray, end: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Return whether boxes lie between places, each (2, ...) from the boxes' centres [m].

    ``half`` are half the boxes' lengths and widths, (2, ...) [m].
    """
    return meets(*(end - begin), *-begin, *half)


def _places(maps: RoadMap, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Return places of the eye, and places where people may be, (place, 2) each [m]."""
    edges = np.asarray(maps.edges[number])
    edges = edges[edges[:, 0] >= 0]
    nodes = np.stack([np.asarray(maps.node_x[number]), np.asarray(maps.node_y[number])], axis=1)
    begin, end = nodes[edges[:, 0]], nodes[edges[:, 1]]
    pieces = np.maximum(np.ceil(np.hypot(*(end - begin).T) / TARGETS).astype(int), 1)
    on_ways = [a + (b - a) * np.linspace(0, 1, count + 1)[:, None]
               for a, b, count in zip(begin, end, pieces, strict=True)]  # fmt: skip
    extents = (float(maps.width[number]), float(maps.height[number]))
    grid = np.stack(np.meshgrid(*(np.arange(0, extent + EYES, EYES) for extent in extents)), -1).reshape(-1, 2)
    roadway = grid[_on_roadway(np.asarray(maps.field[number]), grid)]
    return roadway, np.concatenate([*on_ways, roadway])


def _on_roadway(field: np.ndarray, places: np.ndarray) -> Bool[np.ndarray, " place"]:
    """Return which places (place, 2) are on the roadway, or less than `BESIDE` beyond its edge."""
    column, row = ((places + BEYOND) / FIELD_CELL).astype(int).T
    south_west = np.ascontiguousarray(field[row, column]).view(np.int8)[::4]
    return south_west * UNIT > -BESIDE
