"""A run of a scripted test as OpenSCENARIO XML 1.2: the tested car begins, people wait for it and follow their ways.

Nobody drives the tested car in the file: it has a speed and a route.
"""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType

import numpy as np

from jaxwalk.formats.opendrive import load_library
from jaxwalk.formats.openscenario_parts import (
    VERSION,
    add_parked,
    at_time,
    begins_at,
    body,
    follows,
    our_properties,
    rear_places,
)
from jaxwalk.formats.paths import Path
from jaxwalk.formats.tracks import CAR, PEDESTRIAN, PERSON, TracksError
from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.rails import Footpath, Rails
from jaxwalk.scenarios.staging import Case
from jaxwalk.scenarios.xosc.our_properties import street_name
from jaxwalk.sim.scenario import FAR_AWAY
from jaxwalk.sim.script import Trigger

EGO = "Ego"
"""Name of the tested car."""
FINE, DIGITS = 0.1, 5
"""Time between the points of a run-up [s], and decimals of places [m]."""
STRAIGHT = 1e-3
"""A way is straight if its direction changes by less than this [rad]."""
WAYPOINTS = 5.0
"""Distance of the waypoints of a route that isn't straight [m]."""


def openscenario_script(source: Scripted, number: int, *, road_file: str) -> bytes:
    """Return a run as an OpenSCENARIO document.

    Raises TracksError if scenariogeneration is missing, and InexpressibleRun if the standard has no words for the run.

    Args:
        source: the runs.
        number: which of them.
        road_file: name of the OpenDRIVE file beside it.
    """
    library = load_library()
    xosc, writer = library.xosc, _ScriptWriter(library.xosc, source, number)
    entities, init = xosc.Entities(), xosc.Init()
    act = xosc.Act("test", at_time(xosc, "begin", 0.0, "start"))
    writer.add_car(entities, init)
    for person in range(source.script.pace.shape[0]):
        writer.add_person(entities, init, act, person)
    writer.add_parked(entities, init)
    config = source.street.config
    board = xosc.StoryBoard(init, at_time(xosc, "end", config.horizon * config.dt, "stop"))
    if act.maneuvergroup:  # else nobody does anything
        story = xosc.Story("story")
        story.add_act(act)
        board.add_story(story)
    scenario = xosc.Scenario(
        f"{writer.case.test.title}: {writer.title}", "jaxwalk", xosc.ParameterDeclarations(), entities, board,
        xosc.RoadNetwork(roadfile=road_file), xosc.Catalog(), osc_minor_version=VERSION,
        header_properties=our_properties(xosc, writer.properties()),
    )  # fmt: skip
    return library.helpers.prettify(scenario.get_element())


class InexpressibleRun(TracksError):
    """A run can't be said in OpenSCENARIO. The message says why, in one line."""


class _ScriptWriter:
    """Writes the parts of one run."""

    def __init__(self, xosc: ModuleType, source: Scripted, number: int) -> None:
        self.xosc, self.source, self.number = xosc, source, number
        self.case: Case = source.cases[number]
        self.title = f"{self.case.name} at {self.case.speed:g} km/h"
        self.config = source.street.config
        self.rails = Rails.of(source.street.world.maps, 0, int(source.scenarios.route[number]))
        self.start = float(self._of("start"))

    def properties(self) -> dict[str, object]:
        """Return what the standard has no words for."""
        case, passes = self.case, self.case.test.passes
        return {
            "name": case.name, "title": case.test.title, "track": street_name(str(self.source.street.maps[0].name)),
            "route": int(self.source.scenarios.route[self.number]), "impact": passes.most_impact(case.speed),
            "deceleration": passes.deceleration, "keeps": passes.keeps,
        }  # fmt: skip

    def add_car(self, entities, init) -> None:
        """Add the tested car at its place and speed, with its route."""
        xosc, back = self.xosc, self.config.wheelbase / 2
        x, y, heading = (np.array([value]) for value in self.rails.at(self.start))
        path = Path(CAR, np.zeros(1), x, y, heading, self.config.car_length, self.config.car_width)
        limit = float(self._of("limit"))
        entities.add_scenario_object(EGO, body(xosc, path, replace(self.config, max_speed=limit)))
        init.add_init_action(EGO, xosc.TeleportAction(rear_places(xosc, path, back)[0]))
        init.add_init_action(EGO, begins_at(xosc, float(self._of("speed"))))
        route = xosc.Route("route of the tested car")
        places = np.array([self.start, self.rails.length])
        if not self._straight(self.start, self.rails.length):
            count = int((self.rails.length - self.start) / WAYPOINTS) + 2
            places = np.linspace(self.start, self.rails.length, count)
        for place in places.tolist():
            route.add_waypoint(self._place(*self.rails.at(place)), xosc.RouteStrategy.shortest)
        init.add_init_action(EGO, xosc.AssignRouteAction(route))

    def add_person(self, entities, init, act, person: int) -> None:
        """Add somebody, who stands or follows a way once they set out."""
        xosc, who = self.xosc, f"{PEDESTRIAN}{person + 1}"
        way, times = self._way(person)
        if way.points[0, 0] == FAR_AWAY:
            return
        points = np.round(way.points, DIGITS)
        x, y = points.T
        steps = np.diff(points, axis=0)
        heading = np.arctan2(steps[:, 1], steps[:, 0]) if len(steps) else np.zeros(1)
        path = Path(PEDESTRIAN, times, x, y, np.append(heading, heading[-1])[: len(x)], PERSON, PERSON)
        entities.add_scenario_object(who, body(xosc, path, self.config))
        places = rear_places(xosc, path, 0.0)
        init.add_init_action(who, xosc.TeleportAction(places[0]))
        if len(times) < 2:
            return
        line = xosc.Polyline(np.round(times, 6).tolist(), places)
        act.add_maneuver_group(follows(xosc, who, line, self._waits(person), xosc.ReferenceContext.relative))

    def add_parked(self, entities, init) -> None:
        """Add vehicles that stand beside the way."""
        boxes = np.asarray(self.source.script.boxes)[..., self.number]
        add_parked(self.xosc, entities, init, boxes[boxes[:, 4] > 0], self.config)

    def _way(self, person: int) -> tuple[Footpath, np.ndarray]:
        """Return the way of somebody, and when they are at its points [s after setting out]."""
        table = np.stack([self._of(f"path_{axis}", person) for axis in ("x", "y", "along")], axis=1)
        table = table[: 1 + int(np.argmax(table[:, 2] >= table[-1, 2]))]
        way, pace = Footpath(table[:, :2]), float(self._of("pace", person))
        if self.source.script.path_time is not None and self._of("path_time", person)[-1] > 0:
            times = self._of("path_time", person)
            kept = 1 + int(np.argmax(times >= times[-1]))
            points = np.stack([self._of(f"path_{axis}", person)[:kept] for axis in "xy"], axis=1)
            return Footpath(points), times[:kept]
        if pace <= 0:
            return Footpath(way.points[:1]), np.zeros(1)
        run_up = float(self._of("run_up", person))
        gathering = 2 * run_up / pace
        fine = np.linspace(0, gathering, int(np.ceil(gathering / FINE)) + 1)[1:] if run_up else np.zeros(0)
        metres = np.concatenate([run_up * (fine / max(gathering, 1e-9)) ** 2, way.along])
        metres = np.unique(metres[metres <= way.along[-1]])
        gathered = gathering * np.sqrt(np.minimum(metres / run_up, 1)) if run_up else 0.0
        return Footpath(way.at(metres)), gathered + np.maximum(metres - run_up, 0) / pace

    def _waits(self, person: int):
        """Return the trigger of somebody. Raise InexpressibleRun if the standard can't say it."""
        xosc, kind, value = self.xosc, int(self._of("trigger", person)), float(self._of("waits_for", person))
        name, place = f"pedestrian{person + 1} waits", float(self._of("place", person))
        if kind == Trigger.TIME:
            return at_time(xosc, name, max(round(value, 6), 0.0), "start")
        if kind == Trigger.DISTANCE:
            way = round(max(place - value - self.start, 0.0), DIGITS)
            condition = xosc.TraveledDistanceCondition(way)
        else:
            front = place + self.config.car_length / 2
            if not self._straight(self.start, front):
                raise InexpressibleRun(f"{self.title}: people set out by the time to collision, which OpenSCENARIO "
                                  "measures in a straight line, and the car's way there is bent")  # fmt: skip
            condition = xosc.TimeToCollisionCondition(
                round(value, 6), xosc.Rule.lessThan, freespace=True, position=self._place(*self.rails.at(front)),
                distance_type=xosc.RelativeDistanceType.longitudinal, coordinate_system=xosc.CoordinateSystem.entity,
            )  # fmt: skip
        return xosc.EntityTrigger(name, 0, xosc.ConditionEdge.none, condition, EGO)

    def _straight(self, begin: float, end: float) -> bool:
        headings = [self.rails.at(place)[2] for place in np.linspace(begin, end, 100).tolist()]
        return max(headings) - min(headings) < STRAIGHT

    def _place(self, x: float, y: float, heading: float):
        return self.xosc.WorldPosition(round(x, DIGITS), round(y, DIGITS), 0, round(heading, 9))

    def _of(self, name: str, person: int | None = None) -> np.ndarray:
        """Return a field of the run's script, of a person if one is named, in double precision."""
        values = np.asarray(getattr(self.source.script, name))[..., self.number]
        return np.asarray(values if person is None else values[..., person], float)
