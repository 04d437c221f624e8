"""Shields: what each keeps, what it changes, and what happens where its assumption is broken."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.acting import part_of
from jaxwalk.adapters.players import player
from jaxwalk.policies import RouteFollower, shielded
from jaxwalk.policies.shield_names import SHIELD_NAMES, unshielded, with_shield
from jaxwalk.policies.shielding import SHIELDS
from jaxwalk.policies.shields.cbf_shield import CbfShield, touching_radius
from jaxwalk.policies.shields.predictive_shield import PredictiveShield
from jaxwalk.policies.shields.rss_shield import RssShield, _meets, response_of
from jaxwalk.runs.contestant_names import ContestantError, check_name, run_folders
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.safety.rss import PERSON, braking_way, forward_way
from jaxwalk.sim.prediction import AWAY
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.testing import check_driver
from policies.shield_scenes import (
    BATCH,
    RULES,
    STREET,
    THROTTLE,
    alone,
    decide,
    decide_on,
    drive_past,
    judge,
    judge_one,
    scenes,
)
from pytrees import the_same

KINDS = [pytest.param(make(), id=name) for name, make in SHIELDS.items()]


def crowds(seed):
    """Actions, and scenes with a few people near the car and one who isn't perceived."""
    random = np.random.default_rng(seed)
    people = random.uniform([[[-10]], [[-6]], [[-2]], [[-2]]], [[[25]], [[6]], [[2]], [[2]]], (4, 4, BATCH))
    people[:, 0] = np.array([AWAY, 0, 0, 0])[:, None]
    speed, action = random.uniform(0, RULES.max_speed, BATCH), random.uniform(-1, 1, (2, BATCH))
    return action.astype(np.float32), scenes(speed, people, steering=random.uniform(-0.5, 0.5, BATCH))


@pytest.mark.parametrize("shield", KINDS)
def test_what_is_safe_by_its_rule_is_never_changed(shield):
    kept = 0
    for seed in range(3):
        action, scene = crowds(seed)
        verdict = judge(shield, action, scene)
        does, _, record = decide_on(verdict, action, scene)
        safe = np.asarray(verdict.safe)
        np.testing.assert_array_equal(np.asarray(does)[:, safe], action[:, safe])
        np.testing.assert_array_equal(np.asarray(does)[:, ~safe], np.asarray(verdict.instead)[:, ~safe])
        assert not np.asarray(record.changed)[safe].any()
        assert not np.asarray(record.infeasible)[safe].any()
        kept += safe.sum()
    assert 0.05 < kept / (3 * BATCH) < 0.95


def test_a_shield_is_asked_about_its_drivers_action_in_the_scene_that_it_sees():
    action, scene = crowds(0)
    assert the_same(
        eqx.filter_jit(decide)(RssShield(), action, scene), decide_on(judge(RssShield(), action, scene), action, scene)
    )


@pytest.mark.parametrize("shield", KINDS)
def test_without_anybody_every_action_is_safe(shield):
    action = np.random.default_rng(0).uniform(-1, 1, (2, BATCH)).astype(np.float32)
    assert np.asarray(judge(shield, action, scenes(8.0, np.zeros((4, 0, BATCH)))).safe).all()


@pytest.mark.parametrize("shield", KINDS)
def test_somebody_close_in_front_stops_a_throttle(shield):
    assert not alone(8.0, 0, 0, 0, speed=5.0, shield=shield).safe
    assert alone(40.0, 0, 0, 0, speed=5.0, shield=shield).safe


@pytest.mark.parametrize("shield", KINDS)
def test_a_broken_action_stays_broken(shield):
    """So that what plays it stops and says so."""
    action, scene = crowds(0)
    action[0, :5], action[1, 5:9] = np.nan, 1.5
    does, _, record = decide_on(judge(shield, action, scene), action, scene)
    np.testing.assert_array_equal(np.asarray(does)[:, :9], action[:, :9])
    assert not np.logical_or(record.changed, record.infeasible)[:9].any()


@pytest.mark.parametrize("name", SHIELDS)
def test_a_shielded_driver_is_a_driver(name):
    check_driver(shielded(RouteFollower(), name), STREET)


def test_how_near_people_the_predictive_shield_lets_the_car_be():
    """At 0.6 m/s, braking: 0.03 + 0.09 m in two steps more than the throttle's 0.09, and it stands in the fourth.

    0.9, 0.6, 0.3, 0 m/s after 1 to 4 steps: the centre is at 0.09, 0.15 and 0.18 m while it moves, and somebody who
    walks towards it at 2 m/s has come 0.2, 0.4 and 0.6 m. So the room in front must be 0.18 + 0.6 m.
    """
    least = RULES.car_length / 2 + RULES.body_radius + 0.18 + 0.6
    assert alone(least + 0.02, 0, 0, 0, speed=0.6, shield=PredictiveShield()).safe
    assert not alone(least - 0.01, 0, 0, 0, speed=0.6, shield=PredictiveShield()).safe


def test_the_same_if_people_change_their_velocity_steadily():
    """In three steps somebody who stands has gathered 0.1, 0.2 and 0.3 m/s: 0.01 + 0.02 + 0.03 m."""
    steady = PredictiveShield(acceleration=1.0)
    least = RULES.car_length / 2 + RULES.body_radius + 0.18 + 0.06
    assert alone(least + 0.02, 0, 0, 0, speed=0.6, shield=steady).safe
    assert not alone(least - 0.01, 0, 0, 0, speed=0.6, shield=steady).safe
    assert alone(
        10.0, 3.0, 1.4, 0, speed=5.0, shield=steady
    ).safe  # walks beside the way; may turn to it, but not at once
    assert not alone(10.0, 3.0, 1.4, 0, speed=5.0, shield=PredictiveShield()).safe
    assert not alone(4.0, 3.0, 0, -1.4, speed=5.0, shield=steady).safe  # walks into it


def test_braking_as_before_is_what_the_step_before_made_sure_of():
    verdict = alone(4.0, 0, 0, 0, speed=1.0, action=[1, 0.5], shield=PredictiveShield())
    assert verdict.instead.tolist() == [-1, 0]
    assert not verdict.infeasible
    assert alone(3.0, 0, 0, 0, speed=5.0, shield=PredictiveShield()).infeasible  # somebody fell from the sky


def test_rss_brakes_for_who_comes_and_not_for_who_walks_beside():
    """At 5 m/s the car needs 17.2 m; discs of 1.17 m and a body of 0.25 m cover it.

    Who walks at 1.4 m/s reaches 2.39 m, up to 0.475 rad to the side: 1.09 m to the side of a sidewalk 3 m away.
    """
    rss = RssShield()
    assert alone(12.0, 3.0, 1.4, 0, speed=5.0, shield=rss).safe  # 3 - 1.09 > 1.42
    assert alone(12.0, -3.0, 1.4, 0, speed=5.0, shield=rss).safe
    assert not alone(12.0, 3.0, 0, -1.4, speed=5.0, shield=rss).safe  # 3 - 2.39 < 1.42
    assert alone(12.0, 4.0, 0, -1.4, speed=5.0, shield=rss).safe  # 4 - 2.39 > 1.42: who walks must wait
    assert alone(12.0, 3.0, 0, 1.4, speed=5.0, shield=rss).safe  # goes away
    assert alone(12.0, 2.0, 0, 0, speed=5.0, shield=rss).safe  # stands: 2 - 0.5 > 1.42
    assert not alone(12.0, 1.8, 0, 0, speed=5.0, shield=rss).safe


@jax.jit
def in_danger(action, scene):
    """Whether the car must not meet somebody, if it looks at everybody; and with which pedal it brakes enough."""
    rules, car, pace = scene.world.rules, scene.car, jnp.hypot(scene.people.ahead_speed, scene.people.left_speed)
    response = response_of(rules)

    def meet(way, reach):
        pairs = (jnp.broadcast_to(x, pace.shape) for x in (rules.max_steering * action[1], way(car.speed, response)))
        return _meets(rules, scene.people, *pairs, reach(pace, PERSON))

    dangerous = (meet(braking_way, forward_way) & meet(forward_way, braking_way)).any(axis=0)
    return dangerous, -response.braking / rules.max_braking


@pytest.mark.parametrize("seed", range(3))
def test_rss_looks_at_everybody_who_could_come_in_the_way(seed):
    """It passes over who is too far away, and looks the second time only at whom the car must not meet."""
    action, scene = crowds(seed)
    dangerous, pedal = map(np.asarray, in_danger(action, scene))
    np.testing.assert_array_equal(judge(RssShield(), action, scene).safe, ~dangerous | (action[0] <= pedal))
    assert 0.1 < dangerous.mean() < 0.9


def test_rss_lets_a_braking_car_brake():
    braking = alone(8.0, 0, 0, 0, speed=5.0, action=[-1, 0.2], shield=RssShield())
    assert braking.safe
    softly = alone(8.0, 0, 0, 0, speed=5.0, action=[-0.5, 0.2], shield=RssShield())
    assert not softly.safe
    np.testing.assert_allclose(softly.instead, [-1, 0.2])


def test_the_barrier_lets_a_car_brake_beside_somebody():
    """By h alone it couldn't: it falls by more than a fifth, as the speed does."""
    assert alone(2.0, 4.0, 0, 0, speed=1.0, action=[-1, 0], shield=CbfShield()).safe


def test_where_no_action_is_feasible_the_barrier_takes_the_best_and_says_so():
    row = np.zeros((4, 7, 1))
    row[0], row[1, :, 0] = 6.0, np.arange(-6, 7, 2)
    verdict = judge_one(CbfShield(), THROTTLE, scenes(8.0, row))
    assert verdict.infeasible
    assert verdict.instead[0] == -1
    assert not alone(6.0, 0, 0, 0, speed=8.0, shield=CbfShield()).infeasible  # goes round one person


def crossing(speed, aside=6.0, at=20.0):
    """Somebody who walks straight across, from the left, at a constant speed."""
    return lambda t, car: ((at, aside - speed * t), (0.0, -speed))


def runs_at_it(speed, near, aside=2.2, at=30.0):
    """Somebody who stands beside the car's way, and runs at the car once it is this near."""
    place, runs = np.array([at, aside]), [False]

    def walk(t, car):
        to_car = np.array(car) - place
        runs[0] |= float(np.hypot(*to_car)) < near
        velocity = runs[0] * speed * to_car / np.hypot(*to_car)
        here = tuple(place)
        place[:] += velocity * RULES.dt
        return here, tuple(velocity)

    return walk


@pytest.mark.parametrize("shield", KINDS)
@pytest.mark.parametrize("walker", [crossing(1.4, aside=3.8), crossing(1.0, aside=2.7)], ids=["1.4 m/s", "1 m/s"])
def test_who_crosses_as_assumed_is_not_touched(shield, walker):
    assert drive_past(None, walker, speed=4.0)
    assert not drive_past(shield, walker, speed=4.0)


@pytest.mark.parametrize(
    ("name", "near"), [("predictive", 3.5), ("predictive-steady", 3.5), ("rss", 3.5), ("cbf", 5.0)]
)
def test_who_breaks_the_assumption_breaks_the_shield(name, near):
    """Who stands beside the way runs at the car at 8 m/s: faster than anybody is, and without a step before it."""
    assert drive_past(SHIELDS[name](), runs_at_it(8.0, near=near), speed=4.0)


def test_names_of_shielded_drivers():
    assert unshielded("driver", "co-trained+rss") == ("co-trained", "rss")
    assert unshielded("driver", "mine.py:Mine+cbf") == ("mine.py:Mine", "cbf")
    assert unshielded("driver", "co-trained+other") == ("co-trained+other", None)
    assert unshielded("pedestrian", "learned+rss") == ("learned+rss", None)
    assert with_shield(("a", "b"), "rss") == ("a+rss", "b+rss")
    assert with_shield(("a",), None) == ("a",)
    assert tuple(SHIELDS) == SHIELD_NAMES


def test_wrong_shields_are_refused():
    with pytest.raises(ValueError, match="no shield 'paper'; there are: predictive, predictive-steady, rss, cbf"):
        shielded(RouteFollower(), "paper")
    with pytest.raises(ValueError, match="one shield at most"):
        shielded(shielded(RouteFollower(), "rss"), "cbf")


def test_a_shield_can_be_given_as_itself():
    shield = RssShield()
    assert shielded(RouteFollower(), shield).shield is shield


def test_where_contacts_are_of_discs_they_touch_at_the_distance_of_the_rules():
    rules = replace(STREET.world.rules, contact="disc")
    assert touching_radius(rules) is rules.collision_distance


def test_a_shield_knows_nothing_of_people_but_what_the_car_perceives():
    scene = scenes(5.0, np.zeros((4, 4, BATCH)))
    assert scene.scenario.start.shape == scene.scenario.traits.shape[1:] == (0, BATCH)
    assert SimConfig.fastest_walk == PredictiveShield().reach_speed


def test_part_of_the_environments_sees_the_same_street():
    scene = scenes(5.0, np.zeros((4, 4, BATCH)))
    part = part_of(scene, slice(3, 5))
    assert part.shared is scene.shared
    assert part.car.speed.shape == (2,)


def test_a_shielded_driver_comes_from_where_the_bare_one_does(tmp_path):
    bare, behind = (policy_origin("driver", name) for name in ("co-trained", "co-trained+cbf"))
    assert (behind.name, behind.kind, behind.sha256) == ("co-trained+cbf", bare.kind, bare.sha256)
    check_name("driver", "co-trained+rss")
    with pytest.raises(ContestantError, match="nobody: no driver"):
        check_name("driver", "nobody+rss")
    assert run_folders([f"{tmp_path}+rss", "co-trained+rss"]) == [str(tmp_path)]
    driver = contestant(STREET, "driver", "random+predictive")
    assert driver.sample
    assert driver.view.name == "paper"
    assert player("driver", "clearance+rss", SimConfig()).view.name == "route-footprint"
