from __future__ import annotations

import dataclasses
import subprocess
import sys

import pytest

from jaxwalk.learning.config import FAST, PAPER, RoleConfig, TrainConfig
from learning.games import ROLES


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        (RoleConfig, "entropy", -0.1),
        (RoleConfig, "entropy", float("inf")),
        (RoleConfig, "epochs", 0),
        (RoleConfig, "initial_std", 0.0),
        (RoleConfig, "noise", "uniform"),
        (RoleConfig, "observes", ""),
        (RoleConfig, "observes", "global"),
        (RoleConfig, "critic_observes", ()),
        (RoleConfig, "actor_hidden", (32, 0)),
        (TrainConfig, "environments", 0),
        (TrainConfig, "minibatches", 7),
        (TrainConfig, "shards", 0),
        (TrainConfig, "shards", 3),
        (TrainConfig, "learning_rate", 0.0),
        (TrainConfig, "discount", 1.5),
        (TrainConfig, "gae_lambda", -0.1),
        (TrainConfig, "clip", float("nan")),
        (TrainConfig, "credit", "everybody"),
        (TrainConfig, "shared_critic_hidden", (0,)),
    ],
)
def test_impossible_values_are_refused_by_name(kind, name, value):
    config = kind(ROLES) if kind is TrainConfig else kind()
    object.__setattr__(config, name, value)  # past the type checks, which only tests have
    with pytest.raises(ValueError, match=f"^{name} must"):
        config.__post_init__()


def test_somebody_must_learn():
    idle = RoleConfig(fixed=1.0)
    with pytest.raises(ValueError, match="fixed must be below 1"):
        TrainConfig(roles={"driver": idle, "pedestrian": idle})


def test_paper_preset_is_table_ii():
    assert (PAPER.environments, PAPER.steps, PAPER.minibatches, PAPER.updates) == (512, 256, 8, 5000)
    assert PAPER.environments * PAPER.steps * PAPER.updates == pytest.approx(6.55e8, rel=1e-3)
    assert (PAPER.learning_rate, PAPER.discount, PAPER.gae_lambda) == (3e-4, 0.995, 0.95)
    assert (PAPER.clip, PAPER.max_grad_norm, PAPER.credit, PAPER.anneal) == (0.2, 0.5, "shared", False)
    assert [PAPER.roles[role].epochs for role in PAPER.roles] == [4, 4]
    assert (PAPER.roles["driver"].entropy, PAPER.roles["pedestrian"].entropy) == (0.01, 0.03)
    assert (PAPER.roles["driver"].actor_hidden, PAPER.roles["pedestrian"].actor_hidden) == ((256, 256), (128, 128))
    assert PAPER.shared_critic_hidden == (256, 256)


def test_fast_networks_are_no_smaller_than_the_papers():
    for role in PAPER.roles:
        assert FAST.roles[role].actor_hidden >= PAPER.roles[role].actor_hidden


def test_roles_and_their_order():

    single = dataclasses.replace(FAST, pedestrian=dataclasses.replace(FAST.roles["pedestrian"], fixed=1.0, early=0.0))
    assert single.learning_roles == ("driver",)


def test_configuration_loads_without_jax():
    code = "import sys, jaxwalk.learning.config; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
