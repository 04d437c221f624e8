"""Files of scripted tests: what is read, what is refused in words, and how tests are timed, by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.crash_file import load_crash_suite, parse_crash_suite
from jaxwalk.scenarios.crash_suite import CrashFileError, PassRule
from jaxwalk.scenarios.rails import time_to_walk
from jaxwalk.sim.script import Trigger
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.sim.suites import CRASH_SUITES
from jaxwalk.testing import check_source

OWN = """
name = "own"
title = "My tests"
source = "me, today"
[variants.hurried]
speed = 3.0
[[tests]]
name = "crossing"
title = "an adult crosses"
speeds = [20, 30]
meets = 120.0
route = "straight"
variants = ["hurried"]
passes = { impact = { 20 = 0, 30 = 10 } }
[[tests.people]]
path = [[0.0, -4.0], [0.0, 5.0]]
speed = 3.6
run_up = 1.0
hit = 50.0
[[tests.people]]
path = [[20.0, -5.0], [0.0, -5.0]]
distance = 15.0
[[tests.parked]]
at = [-8.0, -2.8]
"""


def own(*changes):
    text = OWN
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return text


@pytest.fixture(scope="module")
def scripted():
    return Scripted.of(parse_crash_suite(OWN, "own.toml"), "own.toml", layers=("standard", "hurried"))


def test_a_file_becomes_a_source(scripted):
    assert [(case.name, case.speed) for case in scripted.cases] == [
        ("crossing", 20), ("crossing", 30), ("crossing, hurried", 20), ("crossing, hurried", 30),
    ]  # fmt: skip
    check_source(scripted)
    assert scripted.describe() | {"hash": ""} == {"kind": "scripted", "suite": "own", "count": 4, "hash": ""}
    assert scripted.street.config.pedestrians == 2


def test_tests_are_timed_by_hand(scripted):
    """Two seconds for the metre of the run-up, and three for the other three metres, at 1 m/s; the route begins at 5 m.

    The car's centre is 2.25 m before the meeting then; it begins 6 s before. Hurried people have 1.8333 m/s.
    """
    script = scripted.script
    assert np.asarray(script.trigger)[:, 0].tolist() == [Trigger.TIME_TO_COLLISION, Trigger.DISTANCE]
    np.testing.assert_allclose(script.waits_for[0], [5, 5, 5 / 1.83333, 5 / 1.83333], rtol=1e-4)
    np.testing.assert_allclose(script.waits_for[1], 15.0)
    np.testing.assert_allclose(script.place, 117.75, atol=1e-4)
    np.testing.assert_allclose(script.start[:2], 117.75 - np.array([20, 30]) / 3.6 * 6, rtol=1e-5)
    np.testing.assert_allclose(script.limit, np.array([20, 30, 20, 30]) / 3.6, rtol=1e-6)
    np.testing.assert_allclose(script.path_x[:, :, 0], [[125, 145], [125, 125]], atol=1e-3)
    np.testing.assert_allclose(script.path_y[:, :, 0], [[64.25, 63.25], [73.25, 63.25]], atol=1e-3)
    np.testing.assert_allclose(script.kerb[0], 0.25, atol=0.011)  # the kerb is 3.75 m beside the lane's middle
    assert np.isinf(script.kerb[1]).all()
    np.testing.assert_allclose(script.boxes[0, :, 0], [117, 65.45, 1, 0, 2.2, 0.9], atol=1e-3)


def test_scripted_people_have_the_paces_of_their_tests(scripted):
    """3.6 km/h and, where nothing is said, 5 km/h; hurried ones 3 km/h more. On jaywalks they are no faster."""
    paces = np.array([[3.6, 3.6, 6.6, 6.6], [5, 5, 8, 8]]) / 3.6
    world, scenarios = scripted.street.world, scripted.scenarios
    for pace in (scenarios.walking_speed(world), scenarios.jaywalking_speed(world)):
        np.testing.assert_allclose(pace, paces, rtol=1e-6)


@pytest.mark.parametrize(("way", "seconds"), [(0.0, 0.0), (0.25, 1.0), (1.0, 2.0), (4.0, 5.0)])
def test_who_gathers_speed_evenly_is_half_as_fast_on_the_way_as_in_the_end(way, seconds):
    assert time_to_walk(way, 1.0, 1.0) == pytest.approx(seconds)
    assert time_to_walk(way, 1.0, 0.0) == way


@pytest.mark.parametrize("name", CRASH_SUITES)
def test_the_suites_that_ship_can_be_read(name):
    suite = load_crash_suite(name)
    assert suite.name == name
    assert any(test.no_brake for test in suite.tests)  # or timid drivers would win
    assert max(max(test.speeds) for test in suite.tests) / 3.6 <= WORLDS["test-track"].max_speed
    assert suite.assumed


def test_each_kind_of_test_has_one_without_need_to_brake():
    """The five kinds of the Euro-NCAP-style suite, by the letters before the hit point."""
    tests = load_crash_suite("euro-ncap-style").tests
    kinds = {test.name[:4] for test in tests if not test.no_brake}
    assert kinds == {"CPNA", "CPFA", "CPNC", "CPLA", "CPTA"} == {test.name[:4] for test in tests if test.no_brake}


LAST = "[[tests.parked]]\nat = [-8.0, -2.8]\n"
STANDS = "[[tests.people]]\npath = [[9.0, 9.0]]\nspeed = 0.0\n"
BOX = "[[tests.parked]]\nat = [-20.0, -2.8]\n"
WRONG = {
    "not TOML": ("name = ", "name ", "own.toml: not TOML that can be read"),
    "unknown key": (
        "hit = 50.0",
        "hits = 50.0",
        "tests.0.people.0.hits: unknown key",
    ),
    "too fast": ("speeds = [20, 30]", "speeds = [20, 30, 80]", "crossing: speeds: 80 km/h is above 72"),
    "no limit": ("speeds = [20, 30]", "speeds = [20, 25, 30]", "passes.impact: nothing for 25 km/h; add it"),
    "two triggers": ("hit = 50.0", "hit = 50.0\ntime = 1.0", "people[0].hit: time decides that too"),
    "no variant": ('variants = ["hurried"]', 'variants = ["slow"]', "variants: there is no slow"),
    "stands": ("speed = 3.6", "speed = 0.0", "path: who stands has a speed of 0 and one point"),
    "no place": ("hit = 50.0", "hit = 150.0", "hit: 150 is no share of the car's width"),
    "two names": ("[[tests]]", OWN[OWN.index("[[tests]]") :] + "[[tests]]", "tests: 2 are called crossing"),
    "times": ("run_up = 1.0\nhit = 50.0", "times = [0.0, 0.1]", "people[0].times: faster than 36 km/h"),
    "one time": ("run_up = 1.0\nhit = 50.0", "times = [0.0]", "people[0].times: 1 for 2 points; write one for each"),
    "back in time": ("run_up = 1.0\nhit = 50.0", "times = [0.0, 0.0]", "they must begin with 0, and each be later"),
    "times and a hit": ("run_up = 1.0", "times = [0.0, 9.0]", "people[0].hit: times say when the person is where"),
    "variants of times": (
        "run_up = 1.0\nhit = 50.0",
        "times = [0.0, 9.0]",
        "people[0].times: variants don't change them; leave out the times or the variants",
    ),
    "beyond alone": (
        "hit = 50.0",
        "time = 1.0\nbeyond = 3.0",
        "people[0].beyond: counts only with distance or time_to",
    ),
    "beyond a hit": (
        "hit = 50.0",
        "hit = 50.0\nbeyond = 3.0",
        "people[0].beyond: counts only with distance or time_to",
    ),
    "begins faster": ("meets = 120.0", "meets = 120.0\nbegins = 25.0", "begins: 25 km/h is above a speed of the test"),
    "too many people": (LAST, LAST + STANDS * 99, "crossing: people: 101 are too many; a test has at most 100"),
    "too many boxes": (LAST, LAST + BOX * 100, "crossing: parked: 101 are too many; a test has at most 100"),
    "far away": ("[0.0, 5.0]]", "[0.0, 5000.0]]", "path: more than 500 m away; is it in metres?"),
    "a car on foot": ("speed = 3.6", "speed = 40.0", "speed: 40 km/h is above 36; choose a lower one"),
    "walks from there": (
        "hit = 50.0",
        "walks = true",
        "walks: the path must lead from behind the place of the meeting",
    ),
    "speeds of nothing": ("20 = 0, 30 = 10", "slow = 0", "passes.impact: its keys must be speeds [km/h], such as 30"),
    "negative": ("speed = 3.6", "speed = -1.0", "tests.0.people.0.speed"),
    "no line": ("meets = 120.0", "meets = { z = 3.0 }", "meets: write metres along the route"),
}
STAGED = {
    "no route": (
        'route = "straight"',
        'route = "north"',
        "route: there is no north; write a number, or one of str",
    ),
    "route number": ('route = "straight"', "route = 9", "route: there is no 9; write a number from 0 to 4"),
    "too short a way": (
        "[[0.0, -4.0], [0.0, 5.0]]\nspeed = 3.6\nrun_up = 1.0\nhit = 50.0",
        "[[-2.0, 0.0], [30.0, 0.0]]\nspeed = 3.6\nwalks = true",
        "path: 4.0 m lead to the meeting, and only 2.0 m are there; begin earlier",
    ),
    "behind the car's start": (
        'route = "straight"\nvariants = ["hurried"]\npasses = { impact = { 20 = 0, 30 = 10 } }\n'
        "[[tests.people]]\npath = [[0.0, -4.0], [0.0, 5.0]]\nspeed = 3.6\nrun_up = 1.0\nhit = 50.0",
        'route = "straight"\nheading = 90.0\n'
        "[[tests.people]]\npath = [[-10.0, 300.0], [30.0, 300.0]]\nspeed = 3.6\nwalks = true",
        "path: the car's front doesn't come there; correct it",
    ),
    "begins too early": ("meets = 120.0", "meets = 30.0", "the car would begin 6 m before its route"),
    "starts beyond": ("meets = 120.0", "meets = 120.0\nstarts_at = 155.0", "starts_at: the route is only 155 m long"),
    "beyond the goal": ("meets = 120.0", "meets = 160.0", "meets: the route is only 155 m long"),
    "never met": ("[0.0, 5.0]]", "[0.0, -3.0]]", "hit: the path doesn't lead to 50 % of the car's front"),
    "never crossed": ("meets = 120.0", "meets = { y = 3.0 }", "meets: the route doesn't cross y = 3"),
    "backwards": ("speed = 3.0", "speed = -5.0", "its people would walk at -1.4 km/h"),
    "no such layer": ("name = ", "name = ", None),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_file_is_refused_in_words(case):
    old, new, message = WRONG[case]
    with pytest.raises(CrashFileError, match=r"own\.toml: ") as error:
        parse_crash_suite(OWN.replace(old, new, 1), "own.toml")
    assert message in str(error.value)


@pytest.mark.parametrize("case", STAGED)
def test_a_test_that_cannot_take_place_is_refused_in_words(case):
    old, new, message = STAGED[case]
    suite = parse_crash_suite(OWN.replace(old, new, 1), "own.toml")
    layers = ("standard", "hurried") if message else ("extended",)
    with pytest.raises(CrashFileError) as error:
        Scripted.of(suite, "own.toml", layers=layers)
    assert (message or "no test is of layer extended; there are standard, hurried") in str(error.value)


def test_an_unknown_suite_names_those_that_there_are(tmp_path):
    with pytest.raises(CrashFileError, match="no such suite of crash tests; use one of euro-ncap-style"):
        load_crash_suite("iihs")
    with pytest.raises(CrashFileError, match="cannot be read"):
        load_crash_suite(tmp_path / "none.toml")


def test_a_file_of_a_megabyte_is_not_read(tmp_path):
    (tmp_path / "own.toml").write_text("#" * 1_000_001)
    with pytest.raises(CrashFileError, match=r"own\.toml: larger than 1,000,000 bytes, which no tests need"):
        load_crash_suite(tmp_path / "own.toml")


def test_a_speed_without_an_impact_of_its_own_asks_for_none():
    rule = PassRule(impact={"20": 0.0, "30": 10.0})
    assert [rule.most_impact(speed) for speed in (20.0, 30.0, 25.0)] == [0.0, 10.0, None]
    assert PassRule(impact=5.0).most_impact(25.0) == 5.0


def test_somebody_who_walks_already_is_met_after_the_test_s_time():
    """4 s at 1 m/s before the place of the meeting, and the car begins 4 s before it."""
    walks = own(
        ("path = [[0.0, -4.0], [0.0, 5.0]]", "path = [[-10.0, 0.0], [30.0, 0.0]]"), ("run_up = 1.0\n", ""),
        ("hit = 50.0", "walks = true"),
    )  # fmt: skip
    script = Scripted.of(parse_crash_suite(walks, "own.toml"), "own.toml").script
    np.testing.assert_allclose(script.path_x[0, 0], 121, atol=1e-3)
    np.testing.assert_allclose(script.start, 117.75 - np.array([20, 30]) / 3.6 * 4, rtol=1e-5)
    assert replace(parse_crash_suite(walks, "own.toml"), name="own").tests[0].people[0].walks


def test_the_file_of_the_documentation_can_be_played():
    page = (Path(__file__).parents[2] / "docs" / "crash-tests.md").read_text()
    text = page.split("```toml\n")[1].split("```")[0]
    found = Scripted.of(parse_crash_suite(text, "the docs"), "the docs", layers=("standard", "hurried"))
    assert len(found) == 8
