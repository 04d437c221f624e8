"""What is wrong in a suite of scripted tests whose fields have the right types."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

from jaxwalk.scenarios.crash_suite import (
    FARTHEST,
    FASTEST_CAR,
    FASTEST_PERSON,
    MOST_BOXES,
    MOST_PEOPLE,
    MOST_POINTS,
    CrashSuite,
    ScriptedPerson,
    ScriptedTest,
    by_speed,
)


def suite_faults(suite: CrashSuite) -> Iterator[str]:
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
    if test.begins is not None and test.begins > min(test.speeds):
        yield f"begins: {test.begins:g} km/h is above a speed of the test; choose a lower one"
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
        if person.times and test.variants:
            yield f"people[{number}].times: variants don't change them; leave out the times or the variants"


def _speed_faults(field: str, table: object, test: ScriptedTest) -> Iterator[str]:
    """Yield what is wrong with a table that has a value for each speed."""
    if not isinstance(table, dict):
        return
    try:
        found = by_speed(table)
    except ValueError:
        yield f"{field}: its keys must be speeds [km/h], such as 30"
        return
    for speed in test.speeds:
        if speed not in found:
            yield f"{field}: nothing for {speed:g} km/h; add it"


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
    yield from _times_faults(person)
    if person.beyond and person.distance is None and person.time_to_collision is None:
        yield "beyond: counts only with distance or time_to_collision; add one of them, or leave it out"
    if person.stands != (len(person.path) == 1):
        yield "path: who stands has a speed of 0 and one point, who walks has two points or more; correct one of them"
    if person.hit is not None and not 0 <= person.hit <= 100:
        yield f"hit: {person.hit:g} is no share of the car's width; write 0 to 100 per cent"
    if person.walks and (person.run_up or person.path[0][0] >= 0 or person.path[-1][0] < 0):
        yield "walks: the path must lead from behind the place of the meeting to ahead of it, without run_up; correct"
    if person.stands and given:
        yield f"{given[0]}: somebody who stands doesn't set out; leave it out"


def _times_faults(person: ScriptedPerson) -> Iterator[str]:
    times = person.times
    if not times:
        return
    if len(times) != len(person.path):
        yield f"times: {len(times)} for {len(person.path)} points; write one for each"
        return
    if times[0] != 0 or any(late <= early for early, late in pairwise(times)):
        yield "times: they must begin with 0, and each be later than the one before; correct them"
    elif any(math.dist(*points) * 3.6 > FASTEST_PERSON * (late - early) for points, (early, late) in
             zip(pairwise(person.path), pairwise(times), strict=True)):  # fmt: skip
        yield f"times: faster than {FASTEST_PERSON:g} km/h; let the person have more time"
    for name in ("run_up", "hit", "walks"):
        if _given(person, name) and getattr(person, name) != 0:
            yield f"{name}: times say when the person is where; leave one of them out"


def _given(person: ScriptedPerson, name: str) -> bool:
    return getattr(person, name) not in (None, False)
