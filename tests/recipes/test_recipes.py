"""The recipes are what the paper and the pages say, and are read without JAX."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import pytest

from jaxwalk.cli.options import Train
from jaxwalk.cli.train import make_experiment
from jaxwalk.learning.config import GLOBAL
from jaxwalk.metrics.injury import monfort_mueller_mais3
from jaxwalk.recipes import (
    BLIND_CORNER,
    BLIND_CORNER_CVAR,
    BLIND_CORNER_LAGRANGIAN,
    FAST,
    PAPER,
    RECIPES,
    TOWN,
    single_agent,
    with_limits,
)
from jaxwalk.sim.manoeuvres import AHEAD
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.reward import DRIVER_TERMS, PEDESTRIAN_TERMS


def test_paper_preset_is_table_ii():
    train = PAPER.train
    assert (train.environments, train.steps, train.minibatches, train.updates) == (512, 256, 8, 5000)
    assert train.environments * train.steps * train.updates == pytest.approx(6.55e8, rel=1e-3)
    assert (train.learning_rate, train.discount, train.gae_lambda) == (3e-4, 0.995, 0.95)
    assert (train.clip, train.max_grad_norm, train.credit, train.anneal) == (0.2, 0.5, "shared", False)
    assert [role.epochs for role in train.roles.values()] == [4, 4]
    assert (train.roles["driver"].entropy, train.roles["pedestrian"].entropy) == (0.01, 0.03)
    assert (train.roles["driver"].actor_hidden, train.roles["pedestrian"].actor_hidden) == ((256, 256), (128, 128))
    assert train.shared_critic_hidden == (256, 256)


def test_fast_networks_are_no_smaller_than_the_papers():
    for name, role in FAST.train.roles.items():
        assert role.actor_hidden >= PAPER.train.roles[name].actor_hidden


def test_every_recipe_is_registered_under_its_name_and_pays_by_terms_that_exist():
    limited = ["blind-corner-lagrangian", "blind-corner-cvar"]
    assert list(RECIPES) == ["fast", "paper", "town", "blind-corner", *limited]
    for name, recipe in RECIPES.items():
        assert recipe.recipe == name
        assert recipe.driver_weights.keys() <= DRIVER_TERMS.keys()
        assert recipe.pedestrian_weights.keys() <= PEDESTRIAN_TERMS.keys()


def test_the_car_alone_learns_from_as_many_environments():
    assert single_agent(FAST).train.environments == 512
    assert single_agent(FAST).train.learning_roles == ("driver",)


def test_the_car_of_town_sees_further_than_it_needs_to_stop():
    stops_after = TOWN.sim.max_speed / TOWN.sim.max_braking
    assert stops_after < AHEAD
    assert TOWN.sim.max_speed * stops_after / 2 < POINTS[-1] * POINT_SPACING


def test_recipes_with_limits_are_blind_corner_but_for_them():
    for recipe in (BLIND_CORNER_LAGRANGIAN, BLIND_CORNER_CVAR):
        assert replace(with_limits(recipe), recipe="blind-corner") == BLIND_CORNER
        assert not recipe.train.roles["pedestrian"].limits
    contact, critical = BLIND_CORNER_LAGRANGIAN.train.roles["driver"].limits
    assert (contact.cost, contact.limit, critical.cost, critical.limit) == ("contact", 0.01, "critical_time", 0.1)
    # a multiplier of 1 doubles what a contact costs
    assert contact.worth == -BLIND_CORNER.driver_weights["collision"] * BLIND_CORNER.train.reward_scale
    (tail,) = BLIND_CORNER_CVAR.train.roles["driver"].limits
    assert (tail.cost, tail.limit, tail.tail) == ("impact_speed", 5.0, 0.99)
    assert tail.worth * 15 / (1 - tail.tail) == pytest.approx(contact.worth)  # of a contact at 15 m/s
    assert monfort_mueller_mais3(tail.limit) == pytest.approx(0.069, abs=5e-4)


@pytest.mark.parametrize("recipe", [TOWN, BLIND_CORNER])
def test_nothing_in_a_town_knows_how_many_people_there_are_or_where_on_the_map(recipe):
    for role in recipe.train.roles.values():
        assert not {GLOBAL, "paper"} & {role.observes, *role.critic_observes}


def test_train_takes_the_recipes_streets_and_world_unless_told_otherwise():
    assert make_experiment(Train(recipe="town")) == TOWN
    on_two = make_experiment(Train(recipe="town", map=("test:2",)))
    assert (on_two.maps, on_two.sim) == (("test:2",), TOWN.sim)
    assert make_experiment(Train(recipe="fast")).maps == ("paper",)


def test_recipes_load_without_jax():
    code = "import sys, jaxwalk.recipes; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
