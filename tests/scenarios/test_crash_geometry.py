"""The geometry of the named tests, by numbers: where and when an unbraked car on rails would meet people.

Nothing here uses how tests are staged: the car moves along the lanes of the network, people along their way, in small
steps.
"""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from jaxwalk.maps import load_network
from jaxwalk.maps.test_track import ROUTES, TURNS
from jaxwalk.scenarios import Scripted
from jaxwalk.sim.script import Trigger
from jaxwalk.sim.sim_config import WORLDS

LENGTH, WIDTH, WHEELBASE = 4.5, 1.8, 2.5
FINE = 0.001
"""Step [s]."""
LAYERS = {
    "euro-ncap-style": ("standard", "extended", "faster", "slower", "nearer", "turned +20", "turned -20"),
    "fmvss-127": ("standard",),
    "r152": ("standard",),
}
AT = 0.05
"""How far the reference point may be from the hit point [m]."""
WHEN = 0.1
"""How much earlier or later it may be there [s]."""


@pytest.fixture(scope="module", params=LAYERS)
def suite(request):
    return Scripted.load(request.param, layers=LAYERS[request.param])


@pytest.fixture(scope="module")
def lines():
    """The middle of each route from its start on, as a finely sampled polyline."""
    network = load_network("test-track")
    found = []
    for route in network.routes:
        line = shapely.LineString(network.route_line(route))
        metres = np.arange(route.start, line.length, 0.01)
        found.append(shapely.get_coordinates(line.interpolate(metres)))
    return found


def on_rails(line, along):
    """Centre and direction of a car with its centre on a line; it slips outward in a bend."""
    place = along / 0.01
    at = np.array([np.interp(place, np.arange(len(line)), line[:, k]) for k in (0, 1)])
    step = 25  # 0.25 m
    back, ahead = (np.clip(np.round(place).astype(int) + k, 0, len(line) - 1) for k in (-step, step))
    middle = np.clip(np.round(place).astype(int), 0, len(line) - 1)
    before, after = line[middle] - line[back], line[ahead] - line[middle]
    one, other = np.arctan2(before[:, 1], before[:, 0]), np.arctan2(after[:, 1], after[:, 0])
    curvature = (other - one) / 0.25
    return at, (one + other) / 2 - np.arcsin(curvature * WHEELBASE / 2)


def walked(time, pace, run_up):
    """How far somebody has walked, by adding up speeds."""
    speed = np.where(time < 0, 0, np.minimum(pace, pace**2 / (2 * run_up) * time) if run_up else pace)
    return np.concatenate([[0.0], ((speed[1:] + speed[:-1]) / 2 * np.diff(time)).cumsum()])


def meeting(suite, number, line):
    """When the reference point meets the front of the unbraked car [s], and where [% of its width]."""
    script = suite.script
    value = {
        name: np.asarray(column, float)[..., number] for name, column in vars(script).items() if column is not None
    }
    time = np.arange(0, 12, FINE)
    along = value["start"] + value["speed"] * time
    centre, heading = on_rails(line, along)
    sets_out = 0.0
    if value["trigger"][0] == Trigger.TIME_TO_COLLISION:
        sets_out = (value["place"][0] - value["start"]) / value["speed"] - value["waits_for"][0]
    way = walked(time - sets_out, value["pace"][0], value["run_up"][0])
    x, y = (np.interp(way, value["path_along"][:, 0], value[name][:, 0]) for name in ("path_x", "path_y"))
    dx, dy = x - centre[0], y - centre[1]
    ahead = dx * np.cos(heading) + dy * np.sin(heading) - LENGTH / 2
    left = dy * np.cos(heading) - dx * np.sin(heading)
    first = int(np.argmax(ahead <= 0))
    assert first > 0
    return time[first], 100 * (left[first] / WIDTH + 0.5)


def stated(test):
    """The hit point that a test states: for who walks ahead of the car, that of its path."""
    (person,) = test.people
    return person.hit if person.hit is not None else 100 * (person.path[0][1] / WIDTH + 0.5)


def test_the_unbraked_car_meets_people_where_and_when_the_tests_say(suite, lines):
    met = [n for n, case in enumerate(suite.cases) if not case.test.no_brake and case.test.people[0].speed]
    assert met
    for number in met:
        case = suite.cases[number]
        line = lines[int(suite.scenarios.route[number])]
        time, hit = meeting(suite, number, line)
        script = suite.script
        due = float(script.place[0, number] - script.start[number]) / float(script.speed[number])
        assert abs(hit - stated(case.test)) / 100 * WIDTH < AT, (case.name, case.speed, hit)
        assert abs(time - due) < WHEN, (case.name, case.speed, time, due)
        assert due > case.test.start - FINE


def test_the_car_of_these_checks_is_the_world_s():
    world = WORLDS["test-track"]
    assert (world.car_length, world.car_width, world.wheelbase) == (LENGTH, WIDTH, WHEELBASE)


@pytest.mark.parametrize("name", TURNS)
def test_turns_are_two_clothoids_and_an_arc(name, lines):
    """Its length, its angle, and its tightest bend, by hand: clothoids of 2 R alpha and an arc of R beta."""
    turn, line = TURNS[name], lines[ROUTES.index(name)]
    heading = np.unwrap(np.arctan2(*np.diff(line[::25], axis=0).T[::-1]))
    assert np.ptp(heading) == pytest.approx(np.pi / 2, abs=1e-3)
    assert np.abs(np.diff(heading)).max() / 0.25 == pytest.approx(1 / turn.radius, rel=0.01)
    alpha, beta = np.radians(turn.clothoid), np.radians(90 - 2 * turn.clothoid)
    bends = np.abs(np.diff(heading)) / 0.25 > 0.02 / turn.radius
    assert bends.sum() * 0.25 == pytest.approx(turn.radius * (4 * alpha * 0.98 + beta), abs=0.6)


def test_a_child_between_parked_cars_is_hidden_by_them_as_by_hand():
    """The nearer car's front is 1.149 m before the child's way, the other one a metre behind it, both a metre aside."""
    suite = Scripted.load("euro-ncap-style")
    number = next(n for n, case in enumerate(suite.cases) if case.test.name == "CPNCO-50")
    boxes = np.asarray(suite.script.boxes)[..., number]
    x, y, cos, _, half_length, half_width = boxes.T
    assert cos == pytest.approx([1, 1])
    assert 130 - (x + half_length) == pytest.approx([1.149, 1.149 + 4.25 + 1.0], abs=1e-3)
    assert 68.25 - WIDTH / 2 - (y + half_width) == pytest.approx([1.0, 1.0], abs=1e-3)
    assert (2 * half_length).tolist() == pytest.approx([4.25, 4.5])
