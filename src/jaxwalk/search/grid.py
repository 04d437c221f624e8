"""The grid of encounters: episodes of one cell are alike, so that the cells with a contact count different failures.

It was committed before the first search, so that no search could choose it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Final

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.sim.crossing_kind import ContactKind

GRID: Final = 1
"""Version of the grid. Numbers of different grids can't be compared."""
SPEEDS: Final = (10.0, 20.0, 30.0, 40.0)
"""Where the next part of the car's speeds at the contact begins [km/h]."""
TIMES: Final = (1.0, 2.0, 3.0, 4.0)
"""The same of the times to collision when the person is first visible [s]: the car's way from there to the contact,
divided by its speed there. Protocols of crash tests begin at 4 s."""
BEARINGS: Final = (-60.0, -25.0, -8.0, 8.0, 25.0, 60.0)
"""The same of the person's bearings at the contact, from the car's centre to the left of its heading [degrees]. The
corners of the front lie at 22 degrees."""
SIDES: Final = (
    "right side", "right wing", "front, right", "front, middle", "front, left", "left wing", "left side",
)  # fmt: skip
"""Names of the bearings."""
SHAPE: Final = (len(ContactKind), len(SPEEDS) + 1, len(TIMES) + 1, len(BEARINGS) + 1)
"""Number of kinds of contact (the first one is none: a near miss), and parts of each axis."""
CELLS: Final = prod(SHAPE)
"""Number of cells, near misses included."""
NEAR: Final = 2.0
"""An episode without a contact is in a cell if the moving car came this close to somebody [m]."""


@dataclass(frozen=True)
class GridCell:
    """A cell in words."""

    contact: str
    """What the person was doing: crosswalk, jaywalk or sidewalk; none in a near miss."""
    speed: str
    """The car's speed at the contact [km/h]."""
    time: str
    """Time to collision when the person was first visible [s]."""
    side: str
    """Where the person was at the contact, seen from the car."""

    def __str__(self) -> str:
        """Return the cell as a phrase."""
        what = "near miss" if self.contact == ContactKind.NONE.word else f"contact with somebody on a {self.contact}"
        end, _, part = self.side.partition(", ")
        where = f"the {part} of the car's {end}" if part else f"the car's {end}"
        speed, time = _with_unit(self.speed, "km/h"), _with_unit(self.time, "s")
        return f"{what} at {speed}, at {where}, first visible at a time to collision of {time}"


def cells_of(
    contact: Int[np.ndarray, "episode"],
    speed: Float[np.ndarray, "episode"],
    time: Float[np.ndarray, "episode"],
    bearing: Float[np.ndarray, "episode"],
) -> Int[np.ndarray, "episode"]:
    """Return the number of each episode's cell.

    Args:
        contact: its `ContactKind`.
        speed: of the car at the contact [m/s].
        time: time to collision when the person was first visible [s].
        bearing: of the person at the contact [rad], positive to the left.
    """
    parts = (
        np.asarray(contact, np.int64),
        np.searchsorted(SPEEDS, 3.6 * speed, side="right"),
        np.searchsorted(TIMES, time, side="right"),
        np.searchsorted(BEARINGS, np.degrees(bearing), side="right"),
    )
    return np.ravel_multi_index(parts, SHAPE)


def fails(cells: Int[np.ndarray, "cell"]) -> np.ndarray:
    """Return which cells are of contacts."""
    return np.asarray(cells) >= CELLS // SHAPE[0]


def in_words(cell: int) -> GridCell:
    """Return a cell in words."""
    contact, speed, time, bearing = (int(part) for part in np.unravel_index(cell, SHAPE))
    return GridCell(ContactKind(contact).word, part_of_axis(SPEEDS, speed), part_of_axis(TIMES, time), SIDES[bearing])


def _with_unit(part: str, unit: str) -> str:
    """Return a part of an axis with its unit: ``10 to 20 km/h``, ``40 km/h and more``."""
    number, more, _ = part.partition(" and more")
    return f"{number} {unit}{more}"


def part_of_axis(begins: tuple[float, ...], part: int) -> str:
    """Return a part of an axis of numbers from 0, as in ``10 to 20``."""
    if part == len(begins):
        return f"{begins[-1]:g} and more"
    return f"{begins[part - 1] if part else 0:g} to {begins[part]:g}"
