"""Parts of OpenSCENARIO documents: bodies, places and triggers. A vehicle's place is that of its rear axle.

Its bounding box states where the centre is.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType

import numpy as np
from jaxtyping import Float

from jaxwalk.formats.paths import Path, standing
from jaxwalk.formats.tracks import CAR
from jaxwalk.scenarios.xosc.our_properties import PREFIX
from jaxwalk.sim.sim_config import SimConfig

VERSION = 2
"""Minor version of OpenSCENARIO."""
HEIGHTS = {True: 1.5, False: 1.75}
"""Nominal height of a car (True) and of a pedestrian [m]."""
WHEEL, TRACK, MASS = 0.6, 1.6, 75.0
"""Nominal diameter and distance of the wheels [m], and mass of a pedestrian [kg]."""


def at_time(xosc: ModuleType, name: str, time: float, point: str):
    """Return a trigger at a time [s]."""
    rule = xosc.Rule.greaterOrEqual
    condition = xosc.SimulationTimeCondition(float(time), rule)
    return xosc.ValueTrigger(name, 0, xosc.ConditionEdge.none, condition, triggeringpoint=point)


def begins_at(xosc: ModuleType, speed: float):
    """Return the action that gives a road user its speed at the start [m/s]."""
    sudden = xosc.TransitionDynamics(xosc.DynamicsShapes.step, xosc.DynamicsDimension.time, 0)
    return xosc.AbsoluteSpeedAction(round(speed, 6), sudden)


def body(xosc: ModuleType, path: Path, config: SimConfig):
    """Return a road user's kind and size."""
    is_car = path.type == CAR
    centre = config.wheelbase / 2 if is_car else 0.0
    height = HEIGHTS[is_car]
    box = xosc.BoundingBox(path.width, path.length, height, centre, 0.0, height / 2)
    if not is_car:
        return xosc.Pedestrian("pedestrian", MASS, xosc.PedestrianCategory.pedestrian, box)
    front = xosc.Axle(config.max_steering, WHEEL, TRACK, config.wheelbase, WHEEL / 2)
    rear = xosc.Axle(0.0, WHEEL, TRACK, 0.0, WHEEL / 2)
    limits = config.max_speed, config.max_acceleration, config.max_braking
    return xosc.Vehicle("car", xosc.VehicleCategory.car, box, front, rear, *limits)


def rear_places(xosc: ModuleType, path: Path, back: float) -> list:
    """Return the positions of a path, ``back`` metres behind the centre."""
    x, y = path.x - back * np.cos(path.heading), path.y - back * np.sin(path.heading)
    columns = (values.tolist() for values in (x, y, path.heading))
    return [xosc.WorldPosition(x, y, 0, heading) for x, y, heading in zip(*columns, strict=True)]


def follows(xosc: ModuleType, who: str, line, trigger, context):
    """Return the group of actions with which a road user follows a line with times, from a trigger on.

    Args:
        xosc: the module of scenariogeneration.
        who: its name.
        line: the polyline.
        trigger: when it sets out.
        context: whether the times count from the beginning of the scenario (absolute) or from then (relative).
    """
    trajectory = xosc.Trajectory(f"way of {who}", False)
    trajectory.add_shape(line)
    action = xosc.FollowTrajectoryAction(trajectory, xosc.FollowingMode.position, context, scale=1, offset=0)
    event = xosc.Event(f"{who} sets out", xosc.Priority.parallel)
    event.add_trigger(trigger)
    event.add_action(f"{who} follows the way", action)
    maneuver = xosc.Maneuver(f"maneuver of {who}")
    maneuver.add_event(event)
    group = xosc.ManeuverGroup(f"group of {who}")
    group.add_actor(who)
    group.add_maneuver(maneuver)
    return group


def add_parked(xosc: ModuleType, entities, init, boxes: Float[np.ndarray, "vehicle column"], config: SimConfig) -> None:
    """Add vehicles that stand, by the columns of `jaxwalk.maps.parking_slots.SLOT_COLUMNS`."""
    for number, path in enumerate(standing(boxes)):
        who = f"parked{number}"
        entities.add_scenario_object(who, body(xosc, path, config))
        init.add_init_action(who, xosc.TeleportAction(rear_places(xosc, path, config.wheelbase / 2)[0]))


def our_properties(xosc: ModuleType, values: Mapping[str, object]):
    """Return properties of a file's header that `jaxwalk` reads; those without a value are left out."""
    properties = xosc.Properties()
    for name, value in values.items():
        if value is not None:
            properties.add_property(f"{PREFIX}{name}", str(value))
    return properties
