"""Scripted tests as data. ``docs/crash-tests.md`` describes the fields for authors of tests.

Lengths are in metres, angles in degrees, and speeds in km/h, as protocols have them.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from jaxwalk.maps.file import Index, Name, Number, Point

STANDARD = "standard"
"""The layer of tests that are always played."""
FASTEST_CAR = 72.0
"""Highest speed of a test [km/h], which the world of crash tests allows."""
FASTEST_PERSON = 36.0
"""Highest speed of a person [km/h]."""
MOST_TESTS, MOST_PEOPLE, MOST_BOXES, MOST_POINTS, MOST_BYTES = 200, 100, 100, 1000, 1_000_000
"""Largest numbers of tests of a file, of people and parked vehicles of a test, of points of a path, and of bytes."""
FARTHEST = 500.0
"""Nothing is farther than this from the place of the meeting [m]."""
LONGEST = 60.0
"""No test lasts longer than this [s]."""
_EXACT = ConfigDict(extra="forbid")

Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]


class CrashFileError(ValueError):
    """A file of tests can't be used. The message names it, and says what is wrong and what to do."""


@dataclass(frozen=True, config=_EXACT)
class ScriptedPerson:
    """Somebody who walks along a way of their own, or stands."""

    path: tuple[Point, ...]
    """Points of the way, ahead of the place of the meeting and to its left [m]; one point for who stands."""
    speed: NotNegative = 5.0
    """Speed [km/h]."""
    run_up: NotNegative = 0.0
    """Way on which the speed is gathered [m]."""
    times: tuple[NotNegative, ...] = ()
    """When the person is at each point of the path [s after setting out], in place of a speed."""
    hit: Number | None = None
    """The unbraked car meets the person here: per cent of its width, 0 at the right edge. It decides when they set
    out."""
    walks: bool | None = None
    """Whether the person walks already when the test begins, so that the unbraked car meets them where their path comes
    to the place of the meeting."""
    time: NotNegative | None = None
    """The person sets out at this time [s]."""
    distance: Number | None = None
    """The person sets out when the car's front is this far from the place of the meeting [m]."""
    time_to_collision: NotNegative | None = None
    """The person sets out when the car's front is there in this time, at its present speed [s]."""
    beyond: Number = 0.0
    """``distance`` and ``time_to_collision`` count up to a place so far beyond that of the meeting [m]."""

    @property
    def stands(self) -> bool:
        """Return whether the person never walks."""
        return not self.times and self.speed == 0


@dataclass(frozen=True, config=_EXACT)
class ParkedBox:
    """A parked vehicle."""

    at: Point
    """Its centre, ahead of the place of the meeting and to its left [m]."""
    length: Positive = 4.4
    width: Positive = 1.8
    heading: Number = 0.0
    """Its direction, to the left of that of the car [degrees]."""


@dataclass(frozen=True, config=_EXACT)
class PassRule:
    """What a driver must do; nothing is asked where nothing is said."""

    impact: NotNegative | dict[Name, NotNegative] | None = None
    """Highest speed of an impact [km/h], or one for each speed of the test, for example ``{30 = 0, 35 = 20}``."""
    deceleration: Positive | None = None
    """The driver brakes no harder than this [m/s2]: a test without need to brake."""
    keeps: NotNegative | None = None
    """The car keeps at least this share of its speed."""

    def most_impact(self, speed: float) -> float | None:
        """Return the highest impact speed that passes at a speed of the test [km/h]; None if nothing is asked."""
        if isinstance(self.impact, dict):
            return {float(key): value for key, value in self.impact.items()}.get(speed)
        return self.impact


@dataclass(frozen=True, config=_EXACT)
class Variant:
    """A test with something changed: a layer of robustness. It is timed anew, so that the unbraked car still hits."""

    speed: Number = 0.0
    """People are faster by this [km/h]."""
    start: Annotated[Number, Field(ge=0, lt=1)] = 0.0
    """People begin nearer by this share of their way to the meeting."""
    heading: Number = 0.0
    """The way of people is turned to the left by this, about the place of the meeting [degrees]."""


@dataclass(frozen=True, config=_EXACT)
class ScriptedTest:
    """A test at one or several speeds of the car."""

    name: Name
    title: Name
    """What happens, in a few words."""
    speeds: Annotated[tuple[Positive, ...], Field(min_length=1)]
    """Speeds of the car [km/h]. It begins at this speed and drives no faster."""
    meets: Number | dict[Name, Number]
    """The place of the meeting: metres along the route, or where the route crosses this line of the map, as in
    ``{y = 79.5}``."""
    route: Index | Name | dict[Name, Index | Name] = 0
    """The car's route: its number, its name on the test track, or one for each speed of the test."""
    heading: Number | None = None
    """The direction in which paths lead ahead, to the left of east [degrees]; by default the route's there."""
    start: Positive = 4.0
    """The unbraked car begins at least this long before the meeting [s], and a second before anybody sets out. Where
    people walk already, it begins just so long before."""
    starts_at: NotNegative | None = None
    """Where the car begins [m along its route], in place of ``start``."""
    begins: NotNegative | None = None
    """The car's speed at the start [km/h], if it isn't that of the test."""
    layer: Name = STANDARD
    """The layer of the suite to which it belongs."""
    people: tuple[ScriptedPerson, ...] = ()
    parked: tuple[ParkedBox, ...] = ()
    variants: tuple[Name, ...] = ()
    """The variants that are played too, each as a layer of its own name."""
    passes: PassRule = PassRule()
    """What a driver must do."""

    @property
    def no_brake(self) -> bool:
        """Return whether the driver is asked not to brake."""
        return self.passes.deceleration is not None

    def route_at(self, speed: float) -> int | str:
        """Return the route at a speed [km/h]."""
        return self.route if not isinstance(self.route, dict) else by_speed(self.route)[speed]


@dataclass(frozen=True, config=_EXACT)
class CrashSuite:
    """A set of tests."""

    name: Name
    title: Name
    source: Name
    """Where the tests come from, with its date."""
    tests: Annotated[tuple[ScriptedTest, ...], Field(min_length=1, max_length=MOST_TESTS)]
    assumed: tuple[Name, ...] = ()
    """What is ours, or was not clear in the source."""
    track: Name = "test-track"
    """The street: the name or the file of a map."""
    lasts: Annotated[Number, Field(gt=0, le=LONGEST)] = 20.0
    """A test lasts at most this long [s]."""
    variants: dict[Name, Variant] = Field(default_factory=dict)


def by_speed(table: dict) -> dict:
    """Return a table with a value for each speed [km/h], its keys as numbers. Raise ValueError if one is none."""
    return {float(key): value for key, value in table.items()}
