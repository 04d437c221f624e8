"""An episode as OpenSCENARIO XML 1.2: every road user follows its trajectory, point by point, with times.

The standard places a vehicle by its rear axle; its bounding box states where the centre is.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from types import ModuleType

import numpy as np
from jaxtyping import Float

from jaxwalk.formats.opendrive import load_library
from jaxwalk.formats.paths import Path, paths, standing
from jaxwalk.formats.tracks import CAR, Tracks
from jaxwalk.sim.sim_config import SimConfig

VERSION = 2
"""Minor version of OpenSCENARIO."""
HEIGHTS = {True: 1.5, False: 1.75}
"""Nominal height of a car (True) and of a pedestrian [m]."""
WHEEL, TRACK, MASS = 0.6, 1.6, 75.0
"""Nominal diameter and distance of the wheels [m], and mass of a pedestrian [kg]."""


def openscenario(
    tracks: Tracks, *, name: str, road_file: str, config: SimConfig, parked: Float[np.ndarray, "vehicle column"]
) -> bytes:
    """Return the episode as an OpenSCENARIO document. Raises TracksError if scenariogeneration is missing.

    Args:
        tracks: an episode of the simulator, with all road users in every frame.
        name: the scenario's name.
        road_file: name of the OpenDRIVE file beside it.
        config: gives the car's wheelbase and limits.
        parked: the boxes of parked vehicles (`jaxwalk.maps.parking_slots.SLOT_COLUMNS`).
    """
    library = load_library()
    xosc = library.xosc
    everybody = paths(tracks)
    end = max(path.t[-1] for path in everybody.values())
    entities, init = xosc.Entities(), xosc.Init()
    board = xosc.StoryBoard(init, _at(xosc, "end", end, "stop"))
    act = xosc.Act("episode", _at(xosc, "begin", 0.0, "start"))
    for id, path in everybody.items():
        who = f"{path.type}{id}"
        back = config.wheelbase / 2 if path.type == CAR else 0.0
        entities.add_scenario_object(who, _body(xosc, path, config))
        places = _places(xosc, path, back)
        init.add_init_action(who, xosc.TeleportAction(places[0]))
        act.add_maneuver_group(_follow(xosc, who, path, places))
    for number, path in enumerate(standing(parked)):
        who = f"parked{number}"
        entities.add_scenario_object(who, _body(xosc, path, config))
        init.add_init_action(who, xosc.TeleportAction(_places(xosc, path, config.wheelbase / 2)[0]))
    story = xosc.Story("story")
    story.add_act(act)
    board.add_story(story)
    scenario = xosc.Scenario(
        name, "jaxwalk", xosc.ParameterDeclarations(), entities, board, xosc.RoadNetwork(roadfile=road_file),
        xosc.Catalog(), osc_minor_version=VERSION,
    )  # fmt: skip
    return library.helpers.prettify(scenario.get_element())


def _at(xosc: ModuleType, name: str, time: float, point: str):
    """Return a trigger at a time [s]."""
    rule = xosc.Rule.greaterOrEqual
    condition = xosc.SimulationTimeCondition(float(time), rule)
    return xosc.ValueTrigger(name, 0, xosc.ConditionEdge.none, condition, triggeringpoint=point)


def _body(xosc: ModuleType, path: Path, config: SimConfig):
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


def _places(xosc: ModuleType, path: Path, back: float) -> list:
    """Return the positions of a path, ``back`` metres behind the centre."""
    x, y = path.x - back * np.cos(path.heading), path.y - back * np.sin(path.heading)
    columns = (values.tolist() for values in (x, y, path.heading))
    return [xosc.WorldPosition(x, y, 0, heading) for x, y, heading in zip(*columns, strict=True)]


def _follow(xosc: ModuleType, who: str, path: Path, places: list):
    """Return a group that makes a road user follow its path from time 0 on."""
    trajectory = xosc.Trajectory(f"path of {who}", False)
    trajectory.add_shape(xosc.Polyline(path.t.tolist(), places))
    action = xosc.FollowTrajectoryAction(
        trajectory, xosc.FollowingMode.position, xosc.ReferenceContext.absolute, scale=1, offset=0
    )
    event = xosc.Event(f"{who} follows", xosc.Priority.parallel)
    event.add_trigger(_at(xosc, f"{who} begins", 0.0, "start"))
    event.add_action(f"follow path of {who}", action)
    maneuver = xosc.Maneuver(f"maneuver of {who}")
    maneuver.add_event(event)
    group = xosc.ManeuverGroup(f"group of {who}")
    group.add_actor(who)
    group.add_maneuver(maneuver)
    return group


def read_openscenario(document: bytes) -> dict[int, Path]:
    """Return the paths of centres in a document that `openscenario` wrote, by id."""
    root, found = ET.fromstring(document), {}
    bodies = {one.get("name", ""): one for one in root.iter("ScenarioObject")}
    for group in root.iter("ManeuverGroup"):
        who = next(group.iter("EntityRef")).get("entityRef", "")
        vertices = [(v.get("time"), v.find("Position/WorldPosition")) for v in group.iter("Vertex")]
        t = np.array([float(time or "nan") for time, _ in vertices])
        x, y, heading = (np.array([float(p.attrib[name]) for _, p in vertices if p is not None]) for name in "xyh")
        centre, size = (next(bodies[who].iter(name)).attrib for name in ("Center", "Dimensions"))
        ahead = float(centre["x"])
        kind = who.rstrip("0123456789")
        found[int(who.removeprefix(kind))] = Path(
            type=kind, t=t, x=x + ahead * np.cos(heading), y=y + ahead * np.sin(heading), heading=heading,
            length=float(size["length"]), width=float(size["width"]),
        )  # fmt: skip
    return found
