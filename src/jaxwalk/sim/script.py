"""What is written down of an episode beforehand: where the car begins, who walks where and when, and what is parked.

A scenario with a script is a test: nothing in it is drawn.
"""

from __future__ import annotations

from enum import IntEnum

import equinox as eqx
from jaxtyping import Array, Float, Int


class Trigger(IntEnum):
    """What a scripted person waits for before it walks."""

    TIME = 0
    """Time since the start [s]."""
    DISTANCE = 1
    """The car's way to a place of its route [m]."""
    TIME_TO_COLLISION = 2
    """That way, divided by the car's speed [s]."""


class Script(eqx.Module):
    """The script of one episode; of a batch of them, arrays ``(..., *batch)``."""

    start: Float[Array, "*batch"]
    """How far along its route the car begins [m], about its centre."""
    speed: Float[Array, "*batch"]
    """The car's speed at the start [m/s]."""
    limit: Float[Array, "*batch"]
    """The car drives no faster than this [m/s]."""
    path_x: Float[Array, "point ped *batch"]
    """Points of each person's way [m]; two or more. After the last one, it is repeated."""
    path_y: Float[Array, "point ped *batch"]
    path_along: Float[Array, "point ped *batch"]
    """How far along the way each point is [m]."""
    pace: Float[Array, "ped *batch"]
    """Speed of each person after its run-up [m/s]; 0 for who stands. Who has times has no run-up."""
    run_up: Float[Array, "ped *batch"]
    """Way on which a person gathers speed, evenly [m]."""
    kerb: Float[Array, "ped *batch"]
    """How far along its way each person enters the roadway [m]; inf for who doesn't, or is on it from the start."""
    trigger: Int[Array, "ped *batch"]
    """The `Trigger` of each person."""
    waits_for: Float[Array, "ped *batch"]
    """The trigger's time [s] or distance [m]: a person walks once it is reached (`Trigger.TIME`), or undercut."""
    place: Float[Array, "ped *batch"]
    """The place of the car's route to which its way is measured [m], for the car's centre."""
    boxes: Float[Array, "box 6 *batch"]
    """Vehicles that stand beside the way and hide what is behind them: boxes with the columns of
    `jaxwalk.maps.parking_slots.SLOT_COLUMNS`. Those of no size are none."""
    path_time: Float[Array, "point ped *batch"] | None = None
    """When each person is at each point [s after setting out]; all 0 for who walks at a pace of their own, None where
    everybody does."""
