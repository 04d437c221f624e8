"""The recipes are what the paper and the pages say, and are read without JAX."""

from __future__ import annotations

import subprocess
import sys

import pytest

from jaxwalk.recipes import FAST, PAPER, RECIPES, single_agent
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
    assert list(RECIPES) == ["fast", "paper"]
    for name, recipe in RECIPES.items():
        assert recipe.recipe == name
        assert recipe.driver_weights.keys() <= DRIVER_TERMS.keys()
        assert recipe.pedestrian_weights.keys() <= PEDESTRIAN_TERMS.keys()


def test_the_car_alone_learns_from_as_many_environments():
    assert single_agent(FAST).train.environments == 512
    assert single_agent(FAST).train.learning_roles == ("driver",)


def test_recipes_load_without_jax():
    code = "import sys, jaxwalk.recipes; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
