from __future__ import annotations

import subprocess
import sys

import pytest

from jaxwalk.learning.config import RoleConfig, TrainConfig
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


def test_roles_and_their_order():
    single = TrainConfig(ROLES | {"pedestrian": RoleConfig(fixed=1.0)})
    assert single.learning_roles == ("driver",)


def test_configuration_loads_without_jax():
    code = "import sys, jaxwalk.learning.config; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
