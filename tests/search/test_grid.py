"""The grid of encounters: it was committed before the first search, so it stays as it was."""

from __future__ import annotations

import hashlib

import numpy as np

from jaxwalk.search.grid import CELLS, SHAPE, cells_of, fails, in_words
from jaxwalk.sim.crossing_kind import ContactKind


def test_the_grid_is_the_committed_one():
    words = "\n".join(repr(in_words(cell)) for cell in range(CELLS))
    assert SHAPE == (4, 5, 5, 7)
    assert hashlib.sha256(words.encode()).hexdigest()[:16] == "39685d203f5316e9"


def test_cells_by_hand():
    found = cells_of(
        np.array([ContactKind.JAYWALK, ContactKind.NONE, ContactKind.SIDEWALK]),
        np.array([10 / 3.6 + 1e-6, 0.0, 100.0]),
        np.array([0.99, 4.0, np.inf]),
        np.radians([0.0, -61.0, 180.0]),
    )
    words = [in_words(cell) for cell in found.tolist()]
    assert [(x.contact, x.speed, x.time, x.side) for x in words] == [
        ("jaywalk", "10 to 20", "0 to 1", "front, middle"),
        ("none", "0 to 10", "4 and more", "right side"),
        ("sidewalk", "40 and more", "4 and more", "left side"),
    ]
    assert fails(found).tolist() == [True, False, True]
    assert [str(x) for x in words] == [
        "contact with somebody on a jaywalk at 10 to 20 km/h, at the middle of the car's front, "
        "first visible at a time to collision of 0 to 1 s",
        "near miss at 0 to 10 km/h, at the car's right side, first visible at a time to collision of 4 s and more",
        "contact with somebody on a sidewalk at 40 km/h and more, at the car's left side, "
        "first visible at a time to collision of 4 s and more",
    ]
