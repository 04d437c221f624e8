"""Where parked vehicles are in the way of jaywalks, by hand: a straight kerb of 20 m, and one vehicle along it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.maps.parking_slots import BOX, SLOT
from jaxwalk.sim.parked_gaps import APART, NO_SLOT, pack_parked_gaps

BODY = 0.25
LOW, HIGH = 10 - BOX[0] / 2 - BODY, 10 + BOX[0] / 2 + BODY
"""Between these places of the kerb a body touches the vehicle, whose middle is at 10 m."""
ROOM = (SLOT - BOX[0]) / 2 - BODY
"""From there to the middle of the gap to a vehicle in the next slot."""


def entries(street, near, far):
    """The entries of a side whose zone is from ``near`` to ``far`` [m along the kerb]; the other kerb is 6 m away."""
    slot = np.array([[[10, 1.5, 1, 0, BOX[0] / 2, BOX[1] / 2]]], np.float32)
    maps = replace(street.world.maps, slots=slot, slot_count=np.array([1], np.int32))
    ends = {name: np.array([[end, end]], np.float32) for name, end in (("near", near), ("far", far), ("piece", 1.0))}
    x = np.tile(np.arange(20.0, dtype=np.float32), (1, 2, 1))
    y = np.stack([np.zeros(20), np.full(20, 6.0)])[None].astype(np.float32)
    zone = {"x": x, "y": y, "dx": np.ones_like(x), "dy": np.zeros_like(x)}
    found = pack_parked_gaps(maps, {"side": ends, "zone": zone}, BODY)[0, 0]
    return found[found[:, 0] != NO_SLOT]


@pytest.mark.parametrize(
    ("near", "far", "gaps"),
    [
        (0, 20, (LOW - ROOM, HIGH + ROOM)),
        (7.5, 20, (HIGH + ROOM, HIGH + ROOM)),
        (0, 12.5, (LOW - ROOM, LOW - ROOM)),
    ],
    ids=["room on both sides", "none before it", "none behind it"],
)
def test_who_would_step_out_at_a_vehicle_does_beside_it(street, near, far, gaps):
    """The vehicle is in the way from where a body touches it, or at most two tried places earlier, and so behind it."""
    ((slot, low, high, before, behind),) = entries(street, near, far)
    assert slot == 0
    assert LOW - 2 * APART <= low <= LOW + APART and HIGH - APART <= high <= HIGH + 2 * APART
    assert (before, behind) == pytest.approx(gaps, abs=2 * APART)


def test_a_vehicle_that_fills_the_zone_leaves_no_gap(street):
    assert len(entries(street, 7.5, 12.5)) == 0
