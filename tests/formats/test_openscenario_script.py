"""Runs of scripted tests as OpenSCENARIO: valid by the schema, read back to the same script, or left out in words."""

from __future__ import annotations

import numpy as np
import pytest

from formats.schemas import valid
from jaxwalk.exports.scenario_files import MAP, export_tests
from jaxwalk.formats.openscenario_script import InexpressibleRun, openscenario_script
from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.crash_file import parse_crash_suite

TESTS = """
name = "said"
title = "what can be said"
source = "this test"
[[tests]]
name = "all triggers"
title = "people who wait for this and that"
speeds = [36]
meets = 100.0
passes = { impact = 20.0 }
[[tests.people]]
path = [[0.0, -4.0], [0.0, 5.0]]
speed = 5.0
run_up = 1.0
hit = 25.0
[[tests.people]]
path = [[-1.0, -6.0], [-1.0, -2.0], [9.0, -2.0]]
speed = 7.2
time = 1.03
[[tests.people]]
path = [[0.0, -8.0], [0.0, -7.0]]
speed = 3.6
distance = 20.0
beyond = 3.0
[[tests.people]]
path = [[2.0, 6.0], [2.0, 6.0], [2.0, 2.0]]
times = [0.0, 1.5, 4.0]
time_to_collision = 2.5
[[tests.people]]
path = [[20.0, 5.0]]
speed = 0.0
[[tests.parked]]
at = [-5.0, -2.8]
heading = 5.0
[[tests]]
name = "turning"
title = "in a bend"
speeds = [10]
route = "left-10"
meets = { y = 79.5 }
[[tests.people]]
path = [[0.0, -4.0], [0.0, 6.0]]
speed = 5.0
hit = 50.0
[[tests]]
name = "turning, after a while"
title = "in a bend"
speeds = [10]
route = "left-10"
meets = { y = 79.5 }
[[tests.people]]
path = [[0.0, -4.0], [0.0, 6.0]]
speed = 5.0
distance = 9.0
"""


@pytest.fixture(scope="module")
def said():
    return Scripted.of(parse_crash_suite(TESTS, "said.toml"), "said.toml")


@pytest.fixture(scope="module")
def copies(said, tmp_path_factory):
    folder = tmp_path_factory.mktemp("said")
    written, refused = export_tests(said, folder)
    assert written == 2
    return folder, refused


def walked(script, person, run, seconds):
    """Where a person of a run is so long after setting out [m], from the script's columns."""
    path = [np.asarray(getattr(script, f"path_{name}"))[:, person, run] for name in ("x", "y", "along")]
    times = np.zeros(1) if script.path_time is None else np.asarray(script.path_time)[:, person, run]
    pace, run_up = (float(np.asarray(getattr(script, name))[person, run]) for name in ("pace", "run_up"))
    if times[-1] > 0:
        along = np.interp(seconds, times, path[2])
    else:
        gathering = 2 * run_up / pace
        early = run_up * (seconds / max(gathering, 1e-9)) ** 2
        along = np.where(seconds < gathering, early, run_up + pace * (seconds - gathering))
    return np.stack([np.interp(along, path[2], one) for one in path[:2]], axis=1)


@pytest.mark.parametrize(("file", "run"), [("all-triggers-36.xosc", 0), ("turning-after-a-while-10.xosc", 2)])
def test_what_is_written_is_read_as_the_same_script(said, copies, file, run):
    copy = Scripted.load(copies[0] / file)
    ours, theirs = said.script, copy.script
    assert int(copy.scenarios.route[0]) == int(said.scenarios.route[run])
    people = theirs.pace.shape[0]
    for name in ("start", "speed", "limit"):
        np.testing.assert_allclose(
            np.asarray(getattr(theirs, name))[0], np.asarray(getattr(ours, name))[run], atol=1e-3
        )
    moving = [n for n in range(people) if theirs.path_time[-1, n, 0] > 0]
    assert len(moving) == (4 if run == 0 else 1)
    seconds = np.linspace(0, 8, 200)
    for person in moving:
        trigger = int(ours.trigger[person, run])
        assert int(theirs.trigger[person, 0]) == trigger
        until = [float(script.waits_for[person, n]) - (trigger == 1) * float(script.place[person, n])
                 for script, n in ((ours, run), (theirs, 0))]  # fmt: skip
        assert until[0] == pytest.approx(until[1], abs=1e-3), "the way is undercut at the same place"
        there = [walked(script, person, n, seconds) for script, n in ((ours, run), (theirs, 0))]
        assert np.hypot(*(there[0] - there[1]).T).max() < 0.005
    boxes = [np.asarray(script.boxes)[:, :, n] for script, n in ((ours, run), (theirs, 0))]
    kept = [box[box[:, 4] > 0] for box in boxes]
    np.testing.assert_allclose(kept[0], kept[1], atol=1e-4)
    (test,) = copy.suite.tests
    assert (test.name, test.passes) == (said.cases[run].test.name, said.cases[run].test.passes)


def test_it_is_valid(copies):
    for file in copies[0].glob("*.xosc"):
        assert valid(file.read_bytes(), "OpenSCENARIO_1_2.xsd") == []
    assert (copies[0] / MAP).exists()


def test_what_the_standard_has_no_words_for_is_left_out(said, copies):
    assert copies[1] == [
        "turning at 10 km/h: people set out by the time to collision, which OpenSCENARIO measures in a straight line, "
        "and the car's way there is bent"
    ]
    with pytest.raises(InexpressibleRun):
        openscenario_script(said, 1, road_file=MAP)


def test_runs_whose_names_files_cannot_have_get_their_own_files(tmp_path):
    names = ["a b", "a-b", "A/B", "Ü", "é", "long" * 60]
    test = '[[tests]]\nname = "{}"\ntitle = "t"\nspeeds = [36, 36.0000001]\nmeets = 100.0\n'
    text = 'name = "n"\ntitle = "t"\nsource = "s"\n' + "".join(test.format(name) for name in names)
    written, refused = export_tests(Scripted.of(parse_crash_suite(text, "names.toml"), "names.toml"), tmp_path)
    files = sorted(file.name for file in tmp_path.glob("*.xosc"))
    assert (written, refused) == (12, []) and len({name.casefold() for name in files}) == 12
    assert {"a-b-36.xosc", "a-b-36-2.xosc", "a-b-36-3.xosc", "A-B-36-5.xosc", "test-36.xosc"} <= set(files)
    assert max(map(len, files)) < 120
