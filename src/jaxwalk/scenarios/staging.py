"""How a scripted test becomes numbers: where car and people begin, and for what people wait."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.maps import as_network
from jaxwalk.maps.test_track import ROUTES, TEST_TRACK
from jaxwalk.scenarios.crash_suite import (
    STANDARD,
    CrashFileError,
    CrashSuite,
    ParkedBox,
    ScriptedPerson,
    ScriptedTest,
    Variant,
)
from jaxwalk.scenarios.rails import FINELY, Footpath, Rails, meetings, time_to_walk
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import FAR_AWAY
from jaxwalk.sim.script import Trigger

KMH = 3.6
"""1 m/s in km/h."""
BEFORE = 1.0
"""The car begins at least this long before anybody sets out [s]."""


@dataclass(frozen=True)
class Case:
    """One run of a test."""

    test: ScriptedTest
    speed: float
    """The car's speed [km/h]."""
    variant: str | None = None
    """Which variant it is; None for the test itself."""

    @property
    def test_name(self) -> str:
        """Return the name of the test."""
        return self.test.name

    @property
    def no_brake(self) -> bool:
        """Return whether the driver is asked not to brake."""
        return self.test.no_brake

    @property
    def asks(self) -> bool:
        """Return whether the test asks for anything."""
        return self.no_brake or self.test.passes.most_impact(self.speed) is not None

    @property
    def layer(self) -> str:
        """Return the layer of the suite: the test's, or the variant."""
        return self.test.layer if self.variant is None else self.variant

    @property
    def name(self) -> str:
        """Return the test's name, with the variant."""
        return self.test.name if self.variant is None else f"{self.test.name}, {self.variant}"


class StagedPerson(NamedTuple):
    """A person's numbers, with the fields of `jaxwalk.sim.script.Script`."""

    way: Footpath
    times: tuple[float, ...] = ()
    """When the person is at each point [s after setting out]; empty for who walks at a pace."""
    pace: float = 0.0
    run_up: float = 0.0
    kerb: float = np.inf
    trigger: int = Trigger.TIME
    waits_for: float = 0.0
    place: float = 0.0
    met_after: float = np.nan
    """Time from setting out to the meeting with the unbraked car [s]; NaN where none is asked for."""


NOBODY = StagedPerson(Footpath(np.full((2, 2), FAR_AWAY)))
"""Somebody who isn't there."""


class Staged(NamedTuple):
    """A case in numbers."""

    route: int
    start: float
    """Where the car begins [m along its route]."""
    speed: float
    """Its speed [m/s]."""
    limit: float
    """It drives no faster [m/s]."""
    people: tuple[StagedPerson, ...]
    boxes: np.ndarray
    """Parked vehicles (box, 6)."""


class Stage:
    """The street of a suite, on which cases are staged."""

    def __init__(self, street: Street, source: str) -> None:
        """Keep the first map of a street; ``source`` names the suite in errors."""
        self.street, self.source = street, source
        self.rules, self.on_track = street.config, str(street.maps[0].name) == TEST_TRACK
        network = as_network(street.maps[0])
        self.roadway = network.surface("roadway")
        self.routes = len(network.routes)
        shapely.prepare(self.roadway)
        self.known: dict[tuple, StagedPerson] = {}

    def staged(self, case: Case, variant: Variant) -> Staged:
        """Return a case in numbers. Raises CrashFileError if the unbraked car doesn't meet who it should."""
        test, speed = case.test, case.speed / KMH
        route = self._route(case)
        rails = Rails.of(self.street.world.maps, 0, route)
        origin = self._origin(case, rails)
        frame = _Frame.of(rails, origin, test.heading)
        people = tuple(self._known_person(case, frame, rails, number, variant) for number in range(len(test.people)))
        late = origin - self.rules.car_length / 2
        firsts = [person for person in people if not np.isnan(person.met_after)]
        met, after = firsts[0].place if firsts else late, test.start
        if not any(person.walks for person in test.people):
            after = max([test.start, *(person.met_after + BEFORE for person in firsts)])
        start = met - speed * after
        if test.starts_at is not None:
            start = test.starts_at
        if start < 0:
            raise self._error(case, f"the car would begin {-start:.0f} m before its route; let it meet people later")
        if not start < rails.length:
            raise self._error(
                case, f"starts_at: the route is only {rails.length:.0f} m long; let the car begin earlier"
            )
        if not origin < rails.length:
            raise self._error(case, f"meets: the route is only {rails.length:.0f} m long; choose an earlier place")
        begins = speed if test.begins is None else test.begins / KMH
        boxes = np.array([frame.box(box) for box in test.parked]).reshape(-1, 6)
        return Staged(route, start, begins, speed, people, boxes)

    def _route(self, case: Case) -> int:
        route = case.test.route_at(case.speed)
        if isinstance(route, str):
            known = ROUTES if self.on_track else ()
            if route not in known:
                names = f", or one of {', '.join(known)}" if known else ""
                raise self._error(case, f"route: there is no {route}; write a number{names}")
            return known.index(route)
        if not 0 <= route < self.routes:
            raise self._error(case, f"route: there is no {route}; write a number from 0 to {self.routes - 1}")
        return route

    def _origin(self, case: Case, rails: Rails) -> float:
        """Return how far along the route the place of the meeting is [m]."""
        meets = case.test.meets
        if not isinstance(meets, dict):
            return float(meets)
        ((axis, value),) = meets.items()
        found = rails.crossing(axis, value)
        if found is None:
            raise self._error(case, f"meets: the route doesn't cross {axis} = {value:g}; choose another line")
        return found

    def _known_person(self, case: Case, frame: _Frame, rails: Rails, number: int, variant: Variant) -> StagedPerson:
        """Return somebody's numbers. Kept, because they are the same at every speed of the car on a route."""
        key = (case.name, number, frame.along)
        if key not in self.known:
            self.known[key] = self._person(case, frame, rails, case.test.people[number], variant)
        return self.known[key]

    def _person(
        self, case: Case, frame: _Frame, rails: Rails, person: ScriptedPerson, variant: Variant
    ) -> StagedPerson:
        """Return somebody's numbers."""
        way = Footpath(frame.places(np.array(person.path if len(person.path) > 1 else person.path * 2)))
        if person.stands:
            return StagedPerson(way)
        if person.times:
            enters, place = way.enters(self.roadway), frame.along - self.rules.car_length / 2
            return _waiting(StagedPerson(way, person.times, kerb=enters, place=place), person)
        pace = (person.speed + variant.speed) / KMH
        if pace <= 0:
            raise self._error(case, f"its people would walk at {pace * KMH:g} km/h; let them be faster")
        met = self._walking(case, person, pace) if person.walks else self._met(case, rails, person, way)
        if met is not None:
            way = way.turned(np.radians(variant.heading), way.at(met))
            way = way.from_place(met - pace * case.test.start if person.walks else variant.start * met)
            met = pace * case.test.start if person.walks else self._met(case, rails, person, way)
        enters = way.enters(self.roadway)
        place = frame.along - self.rules.car_length / 2
        staged = StagedPerson(way, pace=pace, run_up=person.run_up, kerb=enters, place=place)
        if met is not None:
            seconds = time_to_walk(met, pace, person.run_up)
            place = float(self._meetings(rails, way.at(met)[None]).along[0])
            if np.isnan(place):
                raise self._error(case, "path: the car's front doesn't come there; correct it")
            waits = {} if person.walks else {"trigger": Trigger.TIME_TO_COLLISION, "waits_for": seconds}
            return staged._replace(place=place, met_after=seconds, **waits)
        return _waiting(staged, person)

    def _walking(self, case: Case, person: ScriptedPerson, pace: float) -> float:
        """Return how far along its path somebody who walks already comes to the place of the meeting [m]."""
        path = Footpath(np.array(person.path))
        passed = np.flatnonzero(path.points[:, 0] >= 0)[0]
        (before, _), (after, _) = path.points[passed - 1], path.points[passed]
        share = before / (before - after)
        met = path.along[passed - 1] + share * (path.along[passed] - path.along[passed - 1])
        if met < pace * case.test.start:
            way = pace * case.test.start
            raise self._error(
                case, f"path: {way:.1f} m lead to the meeting, and only {met:.1f} m are there; begin earlier"
            )
        return float(met)

    def _met(self, case: Case, rails: Rails, person: ScriptedPerson, way: Footpath) -> float | None:
        """Return how far somebody has walked when the unbraked car should meet them [m]; None if nothing is asked."""
        if person.hit is None:
            return None
        tried = np.append(np.arange(0, way.along[-1], FINELY), way.along[-1])
        found = self._meetings(rails, way.at(tried))
        beside = np.where(np.isnan(found.along), np.nan, found.left - (person.hit / 100 - 0.5) * self.rules.car_width)
        crosses = np.flatnonzero(beside[:-1] * beside[1:] <= 0)
        if not len(crosses):
            raise self._error(case, f"hit: the path doesn't lead to {person.hit:g} % of the car's front; correct it")
        first = crosses[0]
        share = beside[first] / (beside[first] - beside[first + 1]) if beside[first] else 0.0
        return float(tried[first] + share * (tried[first + 1] - tried[first]))

    def _meetings(self, rails: Rails, places: np.ndarray):
        return meetings(rails, places, half_length=self.rules.car_length / 2, wheelbase=self.rules.wheelbase)

    def _error(self, case: Case, what: str) -> CrashFileError:
        return CrashFileError(f"{self.source}: {case.name} at {case.speed:g} km/h: {what}")


def _waiting(staged: StagedPerson, person: ScriptedPerson) -> StagedPerson:
    """Return somebody with what they wait for."""
    staged = staged._replace(place=staged.place + person.beyond)
    for name in ("time", "distance", "time_to_collision"):
        if getattr(person, name) is not None:
            return staged._replace(trigger=Trigger[name.upper()], waits_for=getattr(person, name))
    return staged


class _Frame(NamedTuple):
    """The frame of a test's paths: at the place of the meeting."""

    along: float
    """How far along the route its origin is [m]."""
    origin: np.ndarray
    """The same in the map (2,) [m]."""
    heading: float
    """Direction ahead [rad]."""

    @classmethod
    def of(cls, rails: Rails, along: float, heading: float | None) -> _Frame:
        x, y, direction = rails.at(along)
        return cls(along, np.array([x, y]), direction if heading is None else np.radians(heading))

    def places(self, points: np.ndarray) -> np.ndarray:
        """Return points ahead and to the left (..., 2) as places of the map [m]."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        ahead, left = points[..., 0], points[..., 1]
        return self.origin + np.stack([ahead * cos - left * sin, ahead * sin + left * cos], axis=-1)

    def box(self, box: ParkedBox) -> np.ndarray:
        """Return a parked vehicle with the columns of a slot."""
        heading = self.heading + np.radians(box.heading)
        return np.array(
            [*self.places(np.array(box.at)), np.cos(heading), np.sin(heading), box.length / 2, box.width / 2]
        )


def cases_of(tests: tuple[ScriptedTest, ...], layers: tuple[str, ...] = (STANDARD,)) -> tuple[Case, ...]:
    """Return the runs of tests that belong to some layers, test after test, from low speeds to high ones."""
    every = [
        Case(test, speed, variant) for test in tests for variant in (None, *test.variants) for speed in test.speeds
    ]
    return tuple(case for case in every if case.layer in layers)


def layers_of(suite: CrashSuite) -> tuple[str, ...]:
    """Return the layers of a suite: those of its tests, and those of its variants."""
    variants = (name for test in suite.tests for name in test.variants)
    return tuple(dict.fromkeys((STANDARD, *(test.layer for test in suite.tests), *variants)))
