"""People who are at a place when the unbraked car is at another (``SynchronizeAction``)."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.scenarios.rails import Footpath, time_to_walk
from jaxwalk.scenarios.xosc.car_line import CarLine
from jaxwalk.scenarios.xosc.elements import XoscRefusal, number, only, part, word
from jaxwalk.scenarios.xosc.positions import Positions, points_of
from jaxwalk.scenarios.xosc.trajectories import vertices
from jaxwalk.scenarios.xosc.triggers import Beginning, Comes, Triggers

MEETS = (
    "SynchronizeAction: people set out by the time to collision, so that the unbraked car meets them; "
    "they don't slow down for a car that brakes"
)
LATE = 0.05
"""Who would set out so long before the start sets out at the start [s]."""
OFF_WAY = 0.5
"""The place of the meeting is at most so far beside the way of the pedestrian [m]."""
AT_BEGIN = 0.01
"""A place of the meeting so near to the beginning of the way is the beginning [m]."""


class MeetingPlan(NamedTuple):
    """How somebody meets the car."""

    speed: float
    """Speed at the meeting [m/s]."""
    run_up: float
    """Way on which it is gathered [m]."""
    waits: Beginning
    """When they set out."""


def meeting_plan(action: ET.Element, way: np.ndarray, positions: Positions, triggers: Triggers) -> MeetingPlan:
    """Return how somebody meets the car. Raise XoscRefusal if a scripted person can't meet it so.

    Args:
        action: the ``SynchronizeAction``.
        way: the way of the pedestrian, float64 (corner, 2) [m].
        positions: where positions are.
        triggers: knows the tested car.
    """
    if word(action, "masterEntityRef") != triggers.tested:
        raise XoscRefusal("SynchronizeAction: masterEntityRef isn't the tested car; let it be")
    met = _metres(way, _place(part(action, "TargetPosition"), positions))
    final = part(action, "FinalSpeed/AbsoluteSpeed")
    speed = number(final, "value")
    if speed <= 0:
        raise XoscRefusal("FinalSpeed: is 0; people walk when the car comes")
    steady = met
    for one in final:
        steady = number(one, "distance") if one.tag == "TargetDistanceSteadyState" else speed * number(one, "time")
    run_up = max(met - steady, 0.0)
    seconds = time_to_walk(met, speed, run_up)
    master = positions.at(part(action, "TargetPositionMaster"))
    return MeetingPlan(speed, run_up, _when(triggers.car, master[:2], seconds))


def _when(car: CarLine, master: tuple[float, ...], seconds: float) -> Beginning:
    """Return when somebody sets out who needs some time [s] until the car's reference point is at a place."""
    place = car.project(master[0], master[1])[0] + car.reference
    early = seconds - (place - car.start) / max(car.speed, 1e-6)
    if early > LATE:
        raise XoscRefusal(f"SynchronizeAction: at its final speed the pedestrian would set out {early:.1f} s "
                          "before the start; let the car begin earlier")  # fmt: skip
    return Beginning(Comes.ARRIVAL, seconds, place)


def _place(position: ET.Element, positions: Positions) -> np.ndarray:
    found = only(position)
    if found.tag != "TrajectoryPosition":
        return np.array(positions.at(position)[:2])
    points = points_of(positions, vertices(found, positions.catalogs))
    return Footpath(points).at(number(found, "s"))


def _metres(way: np.ndarray, place: np.ndarray) -> float:
    """Return how far along a way a place is [m]. Raise XoscRefusal if it is beside the way, or at its beginning."""
    if len(way) < 2:
        raise XoscRefusal("TargetPosition: the pedestrian has no way to it; write a FollowTrajectoryAction")
    line, point = shapely.LineString(way), shapely.Point(place)
    away, metres = float(shapely.distance(line, point)), float(shapely.line_locate_point(line, point))
    if away > OFF_WAY:
        raise XoscRefusal(f"TargetPosition: lies {away:.1f} m beside the way of the pedestrian; correct it")
    if metres < AT_BEGIN:
        raise XoscRefusal("TargetPosition: is where the way of the pedestrian begins; choose a place farther along it")
    return metres
