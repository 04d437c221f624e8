"""The file of scripted tests: its fields, and its parser. ``docs/crash-tests.md`` describes it for authors of tests.

Lengths are in metres, angles in degrees, and speeds in km/h, as protocols have them.
"""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Annotated

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from jaxwalk.maps.file import Index, Name, Number, Point, explain
from jaxwalk.sim.suites import CRASH_SUITES

STANDARD = "standard"
"""The layer of tests that are always played."""
FASTEST_CAR = 72.0
"""Highest speed of a test [km/h], which the world of crash tests allows."""
FASTEST_PERSON = 36.0
"""Highest speed of a person [km/h]."""
MOST_TESTS, MOST_PEOPLE, MOST_BOXES, MOST_POINTS, MOST_BYTES = 200, 20, 20, 50, 1_000_000
"""Largest numbers of tests of a file, of people and parked vehicles of a test, of points of a path, and of bytes."""
FARTHEST = 500.0
"""Nothing is farther than this from the place of the meeting [m]."""
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
        return self.route if not isinstance(self.route, dict) else _by_speed(self.route)[speed]


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
    variants: dict[Name, Variant] = Field(default_factory=dict)


_ADAPTER = TypeAdapter(CrashSuite)


def load_crash_suite(name_or_path: str | Path) -> CrashSuite:
    """Return a suite that ships with jaxwalk, by its name, or that of a file. Raises CrashFileError."""
    source = str(name_or_path)
    if source in CRASH_SUITES:
        file = resources.files("jaxwalk.scenarios").joinpath("protocols", f"{source}.toml")
        return parse_crash_suite(file.read_text(encoding="utf-8"), source)
    if not source.endswith(".toml"):
        known = ", ".join(CRASH_SUITES)
        raise CrashFileError(f"{source}: no such suite of crash tests; use one of {known}, or the path of a .toml file")
    try:
        content = Path(source).read_bytes()[: MOST_BYTES + 1]
        text = content.decode("utf-8-sig")
    except OSError as error:
        raise CrashFileError(f"{source}: cannot be read ({error.strerror}); check the path") from None
    except UnicodeDecodeError:
        raise CrashFileError(f"{source}: not UTF-8 text; save the file as UTF-8") from None
    if len(content) > MOST_BYTES:
        raise CrashFileError(f"{source}: larger than {MOST_BYTES:,} bytes, which no tests need; check the path")
    return parse_crash_suite(text, source)


def parse_crash_suite(text: str, source: str) -> CrashSuite:
    """Return the suite that a file's text describes. Raises CrashFileError, which names ``source``."""
    try:
        suite = _ADAPTER.validate_python(tomllib.loads(text))
    except ValidationError as error:
        fault = explain(dict(error.errors()[0])).replace("docs: maps", "docs: crash-tests")
        raise CrashFileError(f"{source}: {fault}; correct the file") from None
    except (ValueError, RecursionError) as error:  # TOMLDecodeError is a ValueError
        raise CrashFileError(f"{source}: not TOML that can be read ({error}); correct the file") from None
    for fault in _faults(suite):
        raise CrashFileError(f"{source}: {fault}")
    return suite


def _faults(suite: CrashSuite) -> Iterator[str]:
    """Yield what is wrong in a suite whose fields have the right types."""
    for name, count in Counter(test.name for test in suite.tests).items():
        if count > 1:
            yield f"tests: {count} are called {name}; give each its own name"
    for test in suite.tests:
        for fault in (*_test_faults(test), *(_unknown_variants(test, suite))):
            yield f"{test.name}: {fault}"


def _unknown_variants(test: ScriptedTest, suite: CrashSuite) -> Iterator[str]:
    for name in test.variants:
        if name not in suite.variants:
            yield f"variants: there is no {name}; write a table [variants.{name}], or correct the name"


def _test_faults(test: ScriptedTest) -> Iterator[str]:
    if max(test.speeds) > FASTEST_CAR:
        yield f"speeds: {max(test.speeds):g} km/h is above {FASTEST_CAR:g}; choose lower ones"
    if isinstance(test.meets, dict) and (len(test.meets) != 1 or not set(test.meets) <= {"x", "y"}):
        yield "meets: write metres along the route, or a line of the map such as {y = 79.5}"
    tables = {"route": test.route, "passes.impact": test.passes.impact}
    for field, table in tables.items():
        yield from _speed_faults(field, table, test)
    for field, count, most in (("people", len(test.people), MOST_PEOPLE), ("parked", len(test.parked), MOST_BOXES)):
        if count > most:
            yield f"{field}: {count} are too many; a test has at most {most}"
    for number, person in enumerate(test.people):
        for fault in _person_faults(person):
            yield f"people[{number}].{fault}"


def _speed_faults(field: str, table: object, test: ScriptedTest) -> Iterator[str]:
    """Yield what is wrong with a table that has a value for each speed."""
    if not isinstance(table, dict):
        return
    try:
        found = _by_speed(table)
    except ValueError:
        yield f"{field}: its keys must be speeds [km/h], such as 30"
        return
    for speed in test.speeds:
        if speed not in found:
            yield f"{field}: nothing for {speed:g} km/h; add it"


def _by_speed(table: dict) -> dict:
    return {float(key): value for key, value in table.items()}


def _person_faults(person: ScriptedPerson) -> Iterator[str]:
    given = [name for name in ("hit", "walks", "time", "distance", "time_to_collision") if _given(person, name)]
    if len(given) > 1:
        yield f"{given[0]}: {given[1]} decides that too; leave one of them out"
    if not 1 <= len(person.path) <= MOST_POINTS:
        yield f"path: {len(person.path)} points; write 1 to {MOST_POINTS}"
    if any(abs(x) > FARTHEST for point in person.path for x in point):
        yield f"path: more than {FARTHEST:g} m away; is it in metres?"
    if person.speed > FASTEST_PERSON:
        yield f"speed: {person.speed:g} km/h is above {FASTEST_PERSON:g}; choose a lower one"
    if (person.speed == 0) != (len(person.path) == 1):
        yield "path: who stands has a speed of 0 and one point, who walks has two points or more; correct one of them"
    if person.hit is not None and not 0 <= person.hit <= 100:
        yield f"hit: {person.hit:g} is no share of the car's width; write 0 to 100 per cent"
    if person.walks and (person.run_up or person.path[0][0] >= 0 or person.path[-1][0] < 0):
        yield "walks: the path must lead from behind the place of the meeting to ahead of it, without run_up; correct"
    if person.speed == 0 and given:
        yield f"{given[0]}: somebody who stands doesn't set out; leave it out"


def _given(person: ScriptedPerson, name: str) -> bool:
    return getattr(person, name) not in (None, False)
