"""How people walk, where they cross, and that they keep to what they decided."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK, NO_CROSSING
from jaxwalk.sim.sim_config import SimConfig
from sim.maps import rectangles
from sim.play import inside, play, random_actions

MAX_TURN = 2e-3
"""A step as long as this much less than a stride has no corner in it [m]."""


@pytest.fixture(scope="module")
def hesitant(street, scenarios):
    """The same scenarios, but everybody waits at random, for a step or for seconds."""
    drive, go = random_actions(5)
    random = np.random.default_rng(6)
    pauses = random.random((50, *go.shape[1:])) < 0.2
    return play(street, scenarios, drive, go * ~np.repeat(pauses, 10, axis=0))


@pytest.fixture(scope="module")
def eager(street, scenarios):
    """The same scenarios, with many jaywalks."""
    return play(with_jaywalk_multiplier(street, 4.0), scenarios)


@pytest.fixture(scope="module")
def speed(scenarios):
    return 1 + np.asarray(scenarios.traits[1])


@pytest.fixture(scope="module")
def areas():
    return {name: rectangles(name) for name in ("roads", "sidewalks", "crosswalks")}


def moved(played):
    return np.hypot(np.diff(played["x"], axis=0), np.diff(played["y"], axis=0))


def entries(played):
    """Frame, person and environment of each first frame on a roadway."""
    on = played["on_roadway"]
    return np.nonzero(on[1:] & ~on[:-1])


@pytest.mark.parametrize("name", ["always_go", "hesitant", "eager"])
def test_nobody_walks_faster_than_their_speed(request, name, speed):
    played = request.getfixturevalue(name)
    assert (moved(played) <= 0.1 * speed + 1e-4).all()
    velocity = np.hypot(played["vx"], played["vy"])[1:]
    np.testing.assert_allclose(velocity, np.where(played["going"][1:], speed, 0), atol=1e-5)


@pytest.mark.parametrize("name", ["always_go", "hesitant", "eager"])
def test_a_step_is_a_stride_but_where_the_path_turns(request, name, speed):
    played = request.getfixturevalue(name)
    short = (moved(played) < 0.1 * speed - MAX_TURN) & played["going"][1:]
    ends = np.nonzero(short)
    assert ends[0].size > 1000
    directions = np.stack([played["vx"], played["vy"]])
    # Of the last stride before and of the one that turns; the waits between are left out.
    last = directions[:, 0]
    turns = np.zeros(short.shape, bool)
    for t in range(short.shape[0]):
        now = directions[:, t + 1]
        turns[t] = np.hypot(*(now - last)) > 0.02
        last = np.where(played["going"][t + 1], now, last)
    assert turns[short].all()


def test_who_waits_stands_exactly_still(hesitant):
    waits = ~hesitant["going"][1:]
    assert waits.mean() > 0.3
    for name in ("x", "y", "goal", "crossing", "decisions", "on_roadway", "on_crosswalk"):
        np.testing.assert_array_equal(hesitant[name][1:][waits], hesitant[name][:-1][waits])


def test_waiting_changes_when_but_not_where(always_go, hesitant):
    strides = np.concatenate([np.zeros((1, *hesitant["going"].shape[1:]), int), hesitant["going"][1:].cumsum(axis=0)])
    assert strides[-1].max() < 400
    for name in ("x", "y"):
        expected = np.take_along_axis(always_go[name], strides, axis=0)
        np.testing.assert_allclose(hesitant[name], expected, atol=1e-4)
    for name in ("crossing", "decisions", "goal", "arrivals", "on_roadway", "on_crosswalk"):
        expected = np.take_along_axis(always_go[name], strides, axis=0)
        np.testing.assert_array_equal(hesitant[name], expected)


def test_a_goal_reached_changes_the_goal_and_not_the_position(street, scenarios, always_go, speed):
    arrivals, goal = always_go["arrivals"], always_go["goal"]
    np.testing.assert_array_equal(goal, np.take_along_axis(np.asarray(scenarios.goals), arrivals, axis=0))
    gained = np.diff(arrivals, axis=0)
    assert gained.max() == 1
    t, p, e = np.nonzero(gained)
    assert t.size > 1000
    x, y = (np.asarray(axis[0])[goal[t, p, e]] for axis in (street.world.maps.node_x, street.world.maps.node_y))
    for frame in (t, t + 1):  # it is there, within a stride
        away = np.hypot(always_go["x"][frame, p, e] - x, always_go["y"][frame, p, e] - y)
        assert (away <= 0.1 * speed[p, e] + 1e-4).all()


@pytest.mark.parametrize("name", ["always_go", "hesitant", "eager"])
def test_people_are_where_people_may_be(request, name, areas):
    played = request.getfixturevalue(name)
    x, y = played["x"], played["y"]
    on_foot = inside(areas["sidewalks"], x, y, margin=-1e-3) | inside(areas["crosswalks"], x, y, margin=-1e-3)
    jaywalks = (played["crossing"] == JAYWALK) & inside(areas["roads"], x, y)
    assert (on_foot | jaywalks).all()


@pytest.mark.parametrize("name", ["always_go", "hesitant", "eager"])
def test_surfaces_are_those_of_the_map(request, name, areas):
    played = request.getfixturevalue(name)
    for flag, area in (("on_roadway", "roads"), ("on_crosswalk", "crosswalks")):
        noted = played[flag]
        assert noted[inside(areas[area], played["x"], played["y"], margin=1e-3)].all()
        assert not noted[~inside(areas[area], played["x"], played["y"], margin=-1e-3)].any()


@pytest.mark.parametrize("name", ["always_go", "hesitant", "eager"])
def test_type_by_decision_is_type_by_geometry(request, name):
    played = request.getfixturevalue(name)
    crossing, on = played["crossing"], played["on_roadway"]
    assert (crossing[on] != NO_CROSSING).all()
    np.testing.assert_array_equal(crossing[on] == CROSSWALK, played["on_crosswalk"][on])


@pytest.mark.parametrize("name", ["always_go", "hesitant", "eager"])
def test_a_crossing_is_decided_once_and_the_decision_kept(request, name):
    played = request.getfixturevalue(name)
    crossing, decisions = played["crossing"], played["decisions"]
    decided, change = np.diff(decisions, axis=0), np.diff(crossing, axis=0) != 0
    assert set(np.unique(decided)) == {0, 1}
    assert (crossing[1:][decided == 1] != NO_CROSSING).all()
    assert (crossing[1:][change & (decided == 0)] == NO_CROSSING).all()
    assert (decisions[0] == 0).all()
    assert (crossing[0] == NO_CROSSING).all()
    # ... and made: every decision is followed by one crossing of its type, but perhaps the last one.
    t, p, e = entries(played)
    assert played["decisions"][t + 1, p, e].tolist() == played["decisions"][t, p, e].tolist()
    number = np.zeros(decisions.shape[1:], int)
    for frame in np.unique(t):
        who = (p[t == frame], e[t == frame])
        number[who] += 1
        np.testing.assert_array_equal(decisions[frame + 1][who], number[who])
    assert (number >= decisions[-1] - 1).all()


@pytest.mark.parametrize(("name", "multiplier"), [("always_go", 0.25), ("hesitant", 0.25), ("eager", 4)])
def test_a_jaywalk_is_a_number_below_tendency_times_multiplier(request, name, multiplier, scenarios):
    played = request.getfixturevalue(name)
    t, p, e = np.nonzero(np.diff(played["decisions"], axis=0))
    number = np.asarray(scenarios.jaywalk_draw)[played["decisions"][t, p, e], p, e]
    jaywalk = number < np.asarray(scenarios.traits[0])[p, e] * np.float32(multiplier)
    np.testing.assert_array_equal(played["crossing"][t + 1, p, e] == JAYWALK, jaywalk)


def jaywalks(street, played):
    """For each jaywalk: the side where it begins (-1: none), where along the kerb it begins and ends, its slant."""
    m = {name: np.asarray(getattr(street.world.maps, name)[0], float) for name in
         ("node_x", "node_y", "zone_near", "zone_far")}  # fmt: skip
    landing, outer = np.asarray(street.world.maps.zone_node[0]).T
    t, p, e = entries(played)
    jaywalk = (played["crossing"][t + 1, p, e] == JAYWALK) & (t + 2 < len(played["x"]))
    t, p, e = (index[jaywalk] for index in (t, p, e))
    x, y = played["x"].astype(float), played["y"].astype(float)
    here = np.stack([x[t + 1, p, e], y[t + 1, p, e]])
    step = np.stack([x[t + 2, p, e], y[t + 2, p, e]]) - here
    step /= np.hypot(*step)
    side = np.full(t.size, -1)
    begins, ends, slant = np.zeros(t.size), np.zeros(t.size), np.zeros(t.size)
    for s in range(len(landing)):
        origin = np.array([[m["node_x"][landing[s]]], [m["node_y"][landing[s]]]])
        other = np.array([[m["node_x"][landing[s ^ 1]]], [m["node_y"][landing[s ^ 1]]]])
        along = np.array([[m["node_x"][outer[s]]], [m["node_y"][outer[s]]]]) - origin
        along /= np.hypot(*along)
        width = np.hypot(*(other - origin))[0]
        across = (other - origin) / width
        deep = ((here - origin) * across).sum(axis=0)
        forward = (step * across).sum(axis=0)
        place = ((here - origin) * along).sum(axis=0)
        drift = (step * along).sum(axis=0) / np.where(forward > 0.5, forward, 1)
        begin, end = place - drift * deep, place + drift * (width - deep)
        found = (
            (forward > 0.5) & (deep > 1 - 1e-3) & (deep < 1.21)  # the landing is 1 m from the kerb
            & (begin > m["zone_near"][s] - 0.02) & (begin < m["zone_far"][s] + 0.02)
        )  # fmt: skip
        assert (side[found] == -1).all()
        side[found], begins[found], ends[found], slant[found] = s, begin[found], end[found], drift[found]
    return side, begins, ends, slant


@pytest.mark.parametrize("name", ["always_go", "eager"])
def test_jaywalks_lead_from_zone_to_zone_slanted_by_45_degrees_at_most(request, name, street):
    side, _, ends, slant = jaywalks(street, request.getfixturevalue(name))
    assert side.size > 300
    assert (side >= 0).all()
    assert np.abs(slant).max() <= 1 + 5e-3
    assert np.abs(slant).max() > 0.9
    near, far = (np.asarray(zone[0])[side ^ 1] for zone in (street.world.maps.zone_near, street.world.maps.zone_far))
    assert (ends > near - 0.05).all()
    assert (ends < far + 0.05).all()


def test_all_crosswalks_and_all_zones_are_used(street, always_go, areas):
    crossing = always_go["on_roadway"] & always_go["on_crosswalk"]
    x, y = always_go["x"][crossing], always_go["y"][crossing]
    users = [inside(area[None], x, y).sum() for area in areas["crosswalks"]]
    assert len(users) == 6
    assert min(users) > 1000  # steps
    side, _, _, _ = jaywalks(street, always_go)
    assert np.bincount(side, minlength=12).min() >= 5


def test_the_whole_zone_is_used(street, eager):
    side, begins, _, _ = jaywalks(street, eager)
    for s in range(12):
        near, far = (float(zone[0][s]) for zone in (street.world.maps.zone_near, street.world.maps.zone_far))
        reached = (begins[side == s] - near) / (far - near)
        assert reached.min() < 0.15
        assert reached.max() > 0.85


def test_without_jaywalking_nobody_is_on_a_roadway_off_a_crosswalk(street, draw):
    never = with_jaywalk_multiplier(street, 0.0)
    crossings = 0
    for first in range(0, 256 * 8, 256):
        played = play(never, draw(first))
        assert not (played["on_roadway"] & ~played["on_crosswalk"]).any()
        assert not (played["crossing"] == JAYWALK).any()
        crossings += entries(played)[0].size
        if crossings >= 10_000:
            break
    assert crossings >= 10_000


def test_jaywalk_rates_by_quartile_of_tendency(street, draw):
    tendency, jaywalk = [], []
    for first in (0, 256, 512):
        scenario = draw(first)
        played = play(street, scenario)
        t, p, e = np.nonzero(np.diff(played["decisions"], axis=0))
        tendency.append(np.asarray(scenario.traits[0])[p, e])
        jaywalk.append(played["crossing"][t + 1, p, e] == JAYWALK)
    tendency, jaywalk = np.concatenate(tendency), np.concatenate(jaywalk)
    quartile = np.minimum(tendency * 4, 3).astype(int)
    for q in range(4):
        chosen = quartile == q
        low, high = binom.interval(0.999, chosen.sum(), 0.25 * tendency[chosen].mean())
        assert low <= jaywalk[chosen].sum() <= high
        assert 0.25 * tendency[chosen].mean() == pytest.approx((q + 0.5) / 16, rel=0.1)
    assert jaywalk.mean() == pytest.approx(0.125, abs=0.015)


def test_everybody_crosses_every_fifty_seconds_or_more_often(always_go):
    t, _, _ = entries(always_go)
    assert t.size / always_go["x"][0].size >= 1


def test_at_the_kerb_is_the_last_metre_and_a_half_before_a_roadway(always_go, eager, speed):
    config = SimConfig()
    for played in (always_go, eager):
        at, on, crossing, decisions = (played[x] for x in ("at_kerb", "on_roadway", "crossing", "decisions"))
        assert not (at & on).any()
        t, p, e = entries(played)
        assert at[t, p, e].all()  # every entry is announced
        assert not at[t + 1, p, e].any()
        # Walking without a wait, the entry is between (k - 1) and k strides ahead, k frames before its first frame.
        stride = 0.1 * speed[p, e]
        for k in range(2, 30):
            before = t + 1 - k
            known = (before >= 0) & (crossing[before, p, e] != NO_CROSSING)
            known &= decisions[before, p, e] == decisions[t + 1, p, e]
            near = known & (k * stride <= config.kerb_distance - 1e-3)
            far = known & ((k - 1) * stride > config.kerb_distance + 1e-3)
            assert at[before, p, e][near].all()
            assert not at[before, p, e][far].any()


def test_at_the_kerb_only_who_is_about_to_cross(always_go):
    at, on = always_go["at_kerb"], always_go["on_roadway"]
    soon = np.zeros(at.shape, bool)
    for k in range(1, 17):  # the slowest needs 15 steps for 1.5 m
        soon[:-k] |= on[k:]
    assert soon[:-17][at[:-17]].all()
    assert (always_go["crossing"][at] != NO_CROSSING).all()


def test_who_waits_at_the_kerb_stays_at_the_kerb(hesitant):
    at, waits = hesitant["at_kerb"], ~hesitant["going"][1:]
    np.testing.assert_array_equal(at[1:][waits], at[:-1][waits])
    assert (at[:-1] & waits).sum() > 100
