"""A file of OpenSCENARIO XML, versions 1.0 to 1.3, as a scripted test."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydantic import ValidationError

from jaxwalk.maps import MapError, MapText, load_network
from jaxwalk.maps.network_routes import sampled_route
from jaxwalk.scenarios.crash_file import checked_suite, first_fault
from jaxwalk.scenarios.crash_suite import (
    LONGEST,
    MOST_PEOPLE,
    CrashFileError,
    CrashSuite,
    ParkedBox,
    ScriptedPerson,
    ScriptedTest,
)
from jaxwalk.scenarios.rails import Footpath
from jaxwalk.scenarios.xosc.car_line import CarLine
from jaxwalk.scenarios.xosc.catalog_entries import CatalogEntries
from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, part, read_elements, word
from jaxwalk.scenarios.xosc.expressions import without_parameters
from jaxwalk.scenarios.xosc.made_street import ROUTE_BEHIND, made_street
from jaxwalk.scenarios.xosc.our_properties import PREFIX, OurProperties
from jaxwalk.scenarios.xosc.passed_over import other_ends, passed_over, stop_times
from jaxwalk.scenarios.xosc.plain_roads import PlainRoads
from jaxwalk.scenarios.xosc.positions import Positions
from jaxwalk.scenarios.xosc.road_users import PEDESTRIAN, RoadUser, road_users, tested_car
from jaxwalk.scenarios.xosc.tested_way import TestedWay, tested_way
from jaxwalk.scenarios.xosc.trajectories import vertices
from jaxwalk.scenarios.xosc.triggers import Comes, Triggers
from jaxwalk.scenarios.xosc.walkers import PedestrianReader, Walker
from jaxwalk.sim.sim_config import SimConfig

KMH = 3.6
"""1 m/s in km/h."""
SHORTEST_TEST = 20.0
"""A test lasts at least this long [s]."""
LONGEST_TITLE = 200
"""Characters of a title."""
STANDING = 0.05
"""A car slower than this stands [m/s]."""


class XoscScript(NamedTuple):
    """What a file says."""

    suite: CrashSuite
    track: MapText | None
    """The street, if it was made along the way of the car."""
    shift: np.ndarray
    """What was added to places of the file, (2,) [m]."""


def read_xosc(path: Path) -> XoscScript:
    """Return the test of a file. Raises CrashFileError, one line that names what can't be read or played."""
    try:
        root = read_elements(path, "OpenSCENARIO")
        _check_kind(root)
        found = _Reading(without_parameters(root), path).script()
    except ValidationError as error:  # a number that no test can have
        raise CrashFileError(f"{path}: {first_fault(error)}; correct the file") from None
    except (XoscRefusal, RecursionError) as error:
        raise CrashFileError(f"{path}: {error}") from None
    checked_suite(found.suite, str(path))
    return found


def _check_kind(root: ET.Element) -> None:
    """Raise XoscRefusal for files that are no scenario, or of another version."""
    header = part(root, "FileHeader")
    version = word(header, "revMajor"), word(header, "revMinor")
    if version[0] != "1" or version[1] not in ("0", "1", "2", "3"):
        raise XoscRefusal(
            f"FileHeader: version {'.'.join(version)[:20]}; versions 1.0 to 1.3 of OpenSCENARIO XML are read"
        )
    for tag, words in (
        ("Catalog", "is a catalog; name the scenario that uses it"),
        ("ParameterValueDistribution", "has values of parameters for another file; name that one"),
    ):
        if root.find(tag) is not None:
            raise XoscRefusal(f"{tag}: {words}")
    for tag in ("Entities", "Storyboard"):
        part(root, tag)


class _Reading:
    """A document on its way to a script."""

    def __init__(self, document: ET.Element, path: Path) -> None:
        """Read who is there and where they begin."""
        self.document, self.path = document, path
        self.ours = OurProperties.of(document)
        catalogs = CatalogEntries(document, path.parent)
        self.users = road_users(document, catalogs)
        self.car = tested_car(self.users)
        logic = document.find("RoadNetwork/LogicFile")
        roads = PlainRoads(None if logic is None else path.parent / word(logic, "filepath"))
        self.positions = Positions(roads, catalogs, {})
        self.notes: list[str] = []
        self.positions.begins = {one.name: at for one in self.users.values() if (at := self._begin(one)) is not None}

    def _begin(self, user: RoadUser) -> ET.Element | None:
        """Return the position at which a road user begins: where it is put, else where its trajectory begins."""
        for action in user.first:
            if action.tag == "TeleportAction":
                return part(action, "Position")
        for action in user.actions("RoutingAction"):
            follows = action.find("FollowTrajectoryAction")
            if follows is not None:
                return part(vertices(follows, self.positions.catalogs)[0], "Position")
        return None

    def script(self) -> XoscScript:
        """Return the script. Raise XoscRefusal for what can't be played."""
        people = sum(one.kind == PEDESTRIAN for one in self.users.values())
        if people > MOST_PEOPLE:
            raise XoscRefusal(f"Entities: {people} pedestrians are too many; a test has at most {MOST_PEOPLE}")
        self._check_others()
        way = tested_way(self.car, self.positions)
        begin = self.positions.begin(self.car.name)
        rules = SimConfig()
        centre = begin.beside(self.car.size[2], 0.0)
        line, network = self._named_line(), None
        start = ROUTE_BEHIND
        if line is None:
            places = [self.positions.begin(one)[:2] for one in self.positions.begins]
            places += [
                vertex for user in self.users.values() if user.kind == PEDESTRIAN for vertex in self._vertices(user)
            ]
            network = made_street(way.strip, np.array(places), self.path.stem)
            line = network.line
        shift = np.zeros(2) if network is None else network.shift
        along = Footpath(line).along
        size = rules.car_length / 2, rules.car_width / 2, self.car.size[2]
        car = CarLine(line - shift, along, start, *size, way.speed or way.fastest)
        start = car.project(centre.x, centre.y)[0]
        car = car._replace(start=start)
        return XoscScript(self._suite(way, car, shift), None if network is None else network.track, shift)

    def _suite(self, way: TestedWay, car: CarLine, shift: np.ndarray) -> CrashSuite:
        meets = car.start + car.half_length
        origin = Footpath(car.points).at(meets)
        test = ScriptedTest(
            name=self.ours.text("name") or self.path.stem, title=self._title(),
            speeds=(round(max(way.fastest, STANDING) * KMH, 4),), meets=meets, route=self.ours.route,
            heading=0.0, starts_at=car.start, begins=round(min(way.speed, way.fastest) * KMH, 4),
            people=self._people(car, origin), parked=self._parked(origin), passes=self.ours.passes(),
        )  # fmt: skip
        return CrashSuite(
            name=self.path.stem, title=self._title(), source=f"{self.path.name}, OpenSCENARIO XML", tests=(test,),
            assumed=tuple(dict.fromkeys([*self._street_notes(), *way.notes, *self.notes])),
            track=self.ours.track or self.path.stem, lasts=self._lasts(),
        )  # fmt: skip

    def _people(self, car: CarLine, origin: np.ndarray) -> tuple[ScriptedPerson, ...]:
        triggers = Triggers(self.positions, car, self.car.name, self.users)
        reader = PedestrianReader(self.positions, triggers, self._lasts(), self.notes)
        people = [one for one in self.users.values() if one.kind == PEDESTRIAN]
        return tuple(_person(reader.walker(one), car, origin) for one in people)

    def _parked(self, origin: np.ndarray) -> tuple[ParkedBox, ...]:
        found = []
        for one in self.users.values():
            if one.kind != PEDESTRIAN and one is not self.car:
                length, width, ahead = one.size
                pose = self.positions.begin(one.name).beside(ahead, 0.0)
                x, y = (np.array(pose[:2]) - origin).tolist()
                found.append(ParkedBox(at=(x, y), length=length, width=width, heading=float(np.degrees(pose.heading))))
        return tuple(found)

    def _check_others(self) -> None:
        for one in self.users.values():
            action = one.moves()
            if one.kind != PEDESTRIAN and one is not self.car and action is not None:
                raise XoscRefusal(f"{called(one.element)} as {one.name!r}: moves ({action.tag}); only the "
                                  "car that is tested, and pedestrians, may move")  # fmt: skip
        self.notes += [*passed_over(self.document, self.users), *other_ends(self.document, self._lasts())]

    def _street_notes(self) -> list[str]:
        """Return what the street has of the file's road."""
        if self.ours.track:
            return []
        logic = self.positions.roads.path
        road = "The file names no road" if logic is None else f"The road of LogicFile {logic.name} isn't played"
        on_lane = self.positions.on_lane(self.positions.begins[self.car.name]) is not None
        wide = "its roadway as wide as there where the car begins" if on_lane else "its roadway two lanes of 3.5 m"
        return [f"{road}: the street is made along the way of the car, {wide}, with sidewalks."]

    def _vertices(self, user: RoadUser) -> list[tuple[float, float]]:
        """Return all places to which a pedestrian may go [m]."""
        nodes = [one for action in user.actions("RoutingAction") for one in action.iter("Position")]
        return [self.positions.at(one)[:2] for one in nodes]

    def _lasts(self) -> float:
        """Return how long the test lasts [s]: until its stop trigger, if that is late."""
        return min(LONGEST, max([SHORTEST_TEST, *stop_times(self.document)]))

    def _named_line(self) -> np.ndarray | None:
        """Return the route on the street that our own file names, float64 (point, 2) [m]; None without a name."""
        if self.ours.track is None:
            return None
        try:
            network = load_network(self.ours.track)
        except MapError as error:
            reason = " ".join(str(error).split())[:LONGEST_TITLE]
            raise XoscRefusal(f"Property {PREFIX}track: {reason}") from None
        if not self.ours.route < len(network.routes):
            raise XoscRefusal(f"Property {PREFIX}route: there is no route {self.ours.route}; correct it")
        return sampled_route(network, network.routes[self.ours.route]).points

    def _title(self) -> str:
        header = part(self.document, "FileHeader")
        return (self.ours.text("title") or header.get("description") or self.path.stem)[:LONGEST_TITLE]


def _person(walker: Walker, car: CarLine, origin: np.ndarray) -> ScriptedPerson:
    """Return a person of the script."""
    path = tuple((float(x), float(y)) for x, y in walker.points - origin)
    if not len(walker.times):
        return ScriptedPerson(path=path, speed=0.0)
    waits = walker.waits
    when = {
        Comes.AT_ONCE: {}, Comes.TIME: {"time": waits.value},
        Comes.PLACE: {"distance": 0.0, "beyond": waits.value - car.start},
        Comes.ARRIVAL: {"time_to_collision": waits.value, "beyond": waits.place - car.start},
    }[waits.comes]  # fmt: skip
    return ScriptedPerson(path=path, times=tuple(walker.times.tolist()), **when)
