"""Shielded drivers, played: what the predictive shield promises, and what is recorded of a shield."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evaluation.test_hosted import hosted
from jaxwalk import Street
from jaxwalk.evaluation import play
from jaxwalk.learning import mappo
from jaxwalk.metrics import OUTCOMES, measure
from jaxwalk.metrics.contacts import RULES as CONTACT_RULES
from jaxwalk.metrics.contacts import find_contacts, touched_while_moving
from jaxwalk.policies import AlwaysGo, Random, RouteFollower, shielded
from jaxwalk.policies.shields.predictive_shield import PredictiveShield
from jaxwalk.recipes import RECIPES, with_training
from jaxwalk.rollout import TRAINING, seed_key
from jaxwalk.runs.street import fixed_policies, make_street
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.sim_config import WORLDS

EPISODES = 256


@pytest.fixture(scope="module")
def footprint():
    return Street.create(config=WORLDS["paper-footprint"])


def played(street, driver, *, episodes, **more):
    scenarios, keys = Drawn(street, 77).take(np.arange(episodes))
    trajectory = play(street, {"driver": driver, "pedestrian": AlwaysGo()}, scenarios, keys, **more)
    return trajectory, measure(trajectory, config=street.config)


def test_the_predictive_shield_keeps_random_actions_from_touching_anybody(footprint):
    """Nobody is faster than 2 m/s here, and everybody is seen: what the shield assumes."""
    _, bare = played(footprint, Random(), episodes=128)
    trajectory, rows = played(footprint, shielded(Random(), "predictive"), episodes=128)
    assert touched_while_moving(bare).sum() > 20
    assert not touched_while_moving(rows).any()
    assert rows[OUTCOMES].driven.sum() > 0.5 * bare[OUTCOMES].driven.sum()
    assert trajectory.shield_changed.any()
    assert not trajectory.shield_infeasible.any()


def kept_the_assumption(street, driver, first=0):
    """For each contact of the moving car: did the person change velocity steadily since it could last have stopped?"""
    scenarios, keys = Drawn(street, 77).take(np.arange(first, first + EPISODES))
    trajectory = play(street, {"driver": driver, "pedestrian": AlwaysGo()}, scenarios, keys)
    contacts = find_contacts(trajectory, street.config)
    here = contacts.moving & (contacts.rule == CONTACT_RULES.index("footprint"))
    changes = np.hypot(np.diff(trajectory.ped_vx, axis=0), np.diff(trajectory.ped_vy, axis=0))
    where = zip(contacts.frame[here], contacts.episode[here], contacts.ped[here], strict=True)
    return [bool(changes[max(f - 35, 0) : f, e, p].max(initial=0) < 0.1) for f, e, p in where]


@pytest.mark.long
def test_the_steady_shield_touches_only_who_breaks_its_assumption(footprint):
    """People here turn at once, which it assumes they don't: whom it touches has just done so, or set out."""
    assert sum(kept_the_assumption(footprint, RouteFollower())) > 20
    behind = kept_the_assumption(footprint, shielded(RouteFollower(), "predictive-steady"))
    assert behind
    assert not any(behind)


@pytest.mark.long
def test_so_it_does_in_ten_thousand_scenarios(footprint):
    found = [
        kept_the_assumption(footprint, shielded(Random(), "predictive-steady"), first)
        for first in range(0, 10_000, EPISODES)
    ]
    print(f"{sum(map(len, found))} contacts of the moving car, {sum(map(sum, found))} of them with who kept to it")
    assert sum(map(len, found)) > 50
    assert not any(map(any, found))


@pytest.mark.long
def test_so_it_does_where_contacts_are_of_discs(street):
    contact = street.config.contact
    assert contact == "disc"
    assert touched_while_moving(played(street, RouteFollower(), episodes=64)[1], contact).sum() > 20
    behind = played(street, shielded(RouteFollower(), "predictive"), episodes=64)[1]
    assert not touched_while_moving(behind, contact).any()


@pytest.mark.long
def test_people_faster_than_it_assumes_break_the_predictive_shield(footprint):
    """Everybody walks at 1 m/s or more."""
    slow = shielded(RouteFollower(), PredictiveShield(reach_speed=0.3))
    trajectory, rows = played(footprint, slow, episodes=64)
    assert touched_while_moving(rows).any()
    assert trajectory.shield_infeasible.any()
    assert not touched_while_moving(played(footprint, shielded(RouteFollower(), "predictive"), episodes=64)[1]).any()


@pytest.mark.long
def test_a_host_driver_is_shielded_as_the_same_driver_in_jax_is(street):
    trajectory, _ = played(street, shielded(RouteFollower(), "rss"), episodes=16)
    asked, _ = played(street, shielded(hosted(), "rss"), episodes=16)
    for name in ("length", "goal", "collision", "decisions", "shield_changed", "shield_infeasible"):
        np.testing.assert_array_equal(getattr(asked, name), getattr(trajectory, name), err_msg=name)
    np.testing.assert_allclose(asked.car_x, trajectory.car_x, atol=1e-3)
    assert trajectory.shield_changed.any()
    assert not trajectory.shield_changed[0].any()


def test_without_a_shield_nothing_is_recorded_of_one(street):
    trajectory, _ = played(street, RouteFollower(), episodes=16)
    assert trajectory.shield_changed is trajectory.shield_infeasible is None


@pytest.mark.long
@pytest.mark.parametrize("name", ["predictive", "cbf"])
def test_people_can_learn_among_shielded_cars(name):
    """In half of the environments: a shield sees its own part of them, and all of the street."""
    fast = RECIPES["fast"]
    roles = fast.train.roles | {"driver": replace(fast.train.roles["driver"], fixed=0.5)}
    experiment = with_training(fast, environments=8, steps=8, minibatches=2, roles=roles)
    street = make_street(experiment)
    others = fixed_policies(experiment) | {"driver": shielded(RouteFollower(), name)}
    learner = mappo.init(street, experiment.train, seed_key(0, TRAINING), others=others)
    _, metrics = mappo.update(street, experiment.train, learner)
    assert metrics["finite"] == metrics["fixed/driver"] == 1
