"""Groups cross together: members do what their leader does, but nobody stands still on the roadway for it."""

from __future__ import annotations

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxwalk import SimConfig, Street
from jaxwalk.adapters.game import Game
from jaxwalk.evaluation import play
from jaxwalk.policies import AlwaysGo, Groups, Mixture, RouteFollower
from jaxwalk.policies.diffusion import Diffusion
from jaxwalk.policies.gap_acceptance import GapAccepting
from jaxwalk.runs.contestants import contestant, named_policy
from jaxwalk.scenarios import Drawn
from jaxwalk.testing import check_pedestrians

EPISODES = 64


@pytest.fixture(scope="module")
def grouped():
    return Street.create(config=SimConfig(horizon=200, grouped=1.0))


def test_a_leaders_decision_counts_for_its_group():
    """Person 0 leads 1 and 2, 3 leads 4, 5 is alone; of the followers 2 and 4 are on the roadway."""
    people = [0, 1, 1, 1, 0, 0], [0, 0, 0, 3, 3, 5], [0, 0, 1, 0, 1, 0]
    action, leader, goes_on = (np.array(x, kind)[:, None] for x, kind in zip(people, ("i4", "i4", bool), strict=True))
    played, memory = _groups_act(action, leader, goes_on)
    assert np.asarray(played)[:, 0].tolist() == [0, 0, 1, 1, 1, 0] and memory is None


@eqx.filter_jit
def _groups_act(action, leader, goes_on):
    return Groups(_Given(action)).act(jax.random.split(jax.random.key(0), 1), None, (leader, goes_on, None))


class _Given:
    view = AlwaysGo().view

    def __init__(self, action):
        self.action = action

    def init(self, agents, batch):
        return None

    def act(self, key, memory, seen):
        return self.action, memory


@pytest.mark.parametrize("people", [AlwaysGo(), Diffusion(), Mixture((GapAccepting(), AlwaysGo()), (0.5, 0.5))])
def test_groups_keep_the_contract(grouped, people):
    check_pedestrians(Groups(people), grouped)
    assert Groups(people).view.name == people.view.name
    assert Groups(people).sample == getattr(people, "sample", False)


@pytest.mark.long
def test_where_nobody_walks_in_groups_everybody_decides(street):
    check_pedestrians(Groups(GapAccepting()), street)
    scenarios, keys = Drawn(street, 77, 8).take(np.arange(8))
    one, other = (
        play(street, {"driver": RouteFollower(), "pedestrian": people}, scenarios, keys)
        for people in (GapAccepting(), Groups(GapAccepting()))
    )
    np.testing.assert_array_equal(one.ped_x, other.ped_x)


@pytest.fixture(scope="module")
def played(grouped):
    """Trajectories of groups, of people of the same groups who decide for themselves, and how far behind they walk."""
    scenarios, keys = Drawn(grouped, 77, EPISODES).take(np.arange(EPISODES))
    found = [
        play(grouped, {"driver": RouteFollower(), "pedestrian": people}, scenarios, keys)
        for people in (Groups(GapAccepting()), GapAccepting())
    ]
    return found, np.asarray(scenarios.leader).T


def away(trajectory, leader):
    """How far everybody is from its leader in each frame [m], with the frames that were played."""
    x, y = (np.take_along_axis(z, leader[None], axis=2) - z for z in (trajectory.ped_x, trajectory.ped_y))
    return np.hypot(x, y)


def test_groups_stay_together(played):
    (together, apart), leader = played
    behind = 0.7 * (np.arange(12) - leader)
    assert (away(together, leader) <= behind + 0.01).all()
    assert (away(apart, leader) > behind + 2).any()


def test_followers_wait_when_their_leader_does_but_on_the_roadway(played):
    (together, _), leader = played
    going, on_roadway = together.going, together.on_roadway
    leads = np.take_along_axis(going, leader[None], axis=2)
    follows = leader != np.arange(12)
    same = going[1:] == leads[1:]
    assert (same | (follows & on_roadway[:-1])).all()
    assert (~going[1:] & follows & ~leads[1:]).any()
    assert going[1:][follows & on_roadway[:-1]].all()


def test_names_mean_groups_where_people_walk_in_groups(grouped, street):
    assert isinstance(contestant(grouped, "pedestrian", "diffusion"), Groups)
    mixed = contestant(grouped, "pedestrian", "diffusion:0.5+always-go:0.5")
    assert isinstance(mixed, Groups) and isinstance(mixed.people, Mixture)
    assert not any(isinstance(kind, Groups) for kind in mixed.people.kinds)
    assert isinstance(named_policy(grouped, "pedestrian", "diffusion"), Diffusion)
    assert isinstance(contestant(street, "pedestrian", "diffusion"), Diffusion)
    assert not isinstance(contestant(grouped, "driver", "route-follower"), Groups)
    game = Game.create(driver="route-follower", pedestrians="diffusion", config=grouped.config)
    assert isinstance(game.policies["pedestrian"], Groups)
    own = Game.create(driver="route-follower", pedestrians=Diffusion(), config=grouped.config)
    assert isinstance(own.policies["pedestrian"], Diffusion)
