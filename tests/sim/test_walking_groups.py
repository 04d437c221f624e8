"""Groups: how many there are, what their members share, and that they walk one behind the other."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import numpy as np
import pytest
from scipy import stats

from jaxwalk import SimConfig, Street
from jaxwalk.sim import scenario, walking_groups
from jaxwalk.sim.scenario import Scenario, dimensions
from jaxwalk.sim.walking_groups import chances, groups_drawn
from jaxwalk.sim.walking_paths import walking_paths
from sim.passersby import drawn, walked
from sim.play import columns, compiled

RULES = SimConfig(horizon=200, grouped=0.5)
BATCH, STEPS = 256, 150
leaders, from_uniforms = compiled(walking_groups.leaders), eqx.filter_jit(scenario.from_uniforms)


@pytest.fixture(scope="module")
def grouped():
    return Street.create(config=RULES)


@pytest.fixture(scope="module")
def scenarios(grouped):
    return drawn(grouped, BATCH)


@pytest.mark.parametrize(
    ("grouped", "three", "two"), [(0.0, 0.0, 0.0), (0.5, 0.3, 0.3), (5 / 6, 0.5, 0.5), (0.9, 0.7, 0.3), (1.0, 1.0, 0.0)]
)
def test_as_many_people_are_in_groups_as_asked_for(grouped, three, two):
    assert chances(grouped) == pytest.approx((three, two))
    assert three + two * 2 / 3 == pytest.approx(grouped) and three + two <= 1 + 1e-9


def test_leaders_by_hand():
    """Of half of the people: all three below 0.3, two of three below 0.6; two who are left over below 0.5."""
    draws = np.array([0.29, 0.59, 0.61], np.float32)
    assert leaders(draws, 9, 0.5).tolist() == [0, 0, 0, 3, 3, 5, 6, 7, 8]
    assert leaders(draws, 8, 0.5).tolist() == [0, 0, 0, 3, 3, 5, 6, 7]
    assert leaders(np.array([*draws[:2], 0.49], np.float32), 8, 0.5).tolist() == [0, 0, 0, 3, 3, 5, 6, 6]
    assert leaders(np.array([*draws[:2], 0.0], np.float32), 7, 0.5).tolist() == [0, 0, 0, 3, 3, 5, 6]
    assert leaders(draws[:1], 1, 1.0).tolist() == [0]
    assert [groups_drawn(people) for people in (1, 2, 3, 7, 12)] == [1, 1, 1, 3, 4]


def test_groups_are_as_frequent_as_the_share_says(scenarios):
    """1,024 times three people; both counts lie within the exact binomial limits of one draw in 10,000."""
    place = np.arange(12)[:, None] - np.asarray(scenarios.leader)
    threes = (place == 2).sum()
    twos = (place == 1).sum() - threes
    low, high = stats.binom.interval(0.9998, 4 * BATCH, 0.3)
    assert low <= threes <= high and low <= twos <= high


def test_members_have_their_leaders_way_and_pace_and_their_own_last_traits(scenarios):
    leader = np.asarray(scenarios.leader)
    own, follows = np.arange(12)[:, None], np.arange(12)[:, None] != np.asarray(scenarios.leader)
    np.testing.assert_array_equal(np.take_along_axis(leader, leader, axis=0), leader)
    for name in ("start", "goals", "jaywalk_draw", "zone_draw", "traits"):
        x = np.asarray(getattr(scenarios, name))
        same = x == np.take_along_axis(x, np.broadcast_to(leader, x.shape), axis=-2)
        assert same[..., ~follows].all()
        assert (same[:2] if name == "traits" else same).all()
        if name == "traits":
            assert same[2:][:, follows].mean() < 0.01  # numbers are multiples of 2^-16
    assert (own >= leader).all() and follows.any()


def test_groups_take_the_last_numbers_and_leave_leaders_as_they_are(grouped):
    plain = Street.create(config=replace(RULES, grouped=0.0)).world
    numbers = np.random.default_rng(0).random(dimensions(grouped.world)).astype(np.float32)
    assert dimensions(grouped.world) == dimensions(plain) + 4
    found, alone = from_uniforms(grouped.world, numbers), from_uniforms(plain, numbers[:-4])
    assert alone.leader is None
    np.testing.assert_array_equal(found.leader, leaders(numbers[-4:], 12, 0.5))
    leads = np.asarray(found.leader) == np.arange(12)
    for one, other in zip(*map(jax.tree.leaves, (replace(found, leader=None), alone)), strict=True):
        np.testing.assert_array_equal(np.asarray(one)[..., leads], np.asarray(other)[..., leads]) if one.ndim else None
    assert not leads.all()


def test_members_walk_one_behind_the_other(grouped, scenarios):
    """Whoever always goes walks its leader's path at one speed, 0.7 m or 1.4 m behind."""
    some, world = columns(scenarios, slice(16)), grouped.world
    frames = walked(grouped, some)
    x, y = np.asarray(frames.x)[:STEPS], np.asarray(frames.y)[:STEPS]
    paths, speed = walking_paths(world, some, reach=60.0), compiled(Scenario.walking_speed)(some, world)
    leader = np.asarray(some.leader)
    checked = 0
    for ped, e in zip(*np.nonzero(leader != np.arange(12)[:, None]), strict=True):
        place = ped - leader[ped, e]
        metres_walked = np.arange(1, STEPS + 1) * 0.1 * speed[ped, e] - 0.7 * place
        px, py = paths.x[:, leader[ped, e], e], paths.y[:, leader[ped, e], e]
        metres = np.concatenate([[0], np.cumsum(np.hypot(np.diff(px), np.diff(py)))])
        np.testing.assert_allclose(x[:, ped, e], np.interp(metres_walked, metres, px), atol=2e-2)
        np.testing.assert_allclose(y[:, ped, e], np.interp(metres_walked, metres, py), atol=2e-2)
        checked += place == 2
    assert checked > 5


@pytest.mark.parametrize(("share", "message"), [(-0.1, "0 or more"), (1.1, "at most 1")])
def test_an_impossible_share_is_refused(share, message):
    with pytest.raises(ValueError, match=f"grouped must be {message}"):
        SimConfig(grouped=share)
