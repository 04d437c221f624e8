"""The recipe ``fast``: whatever learns best on the paper's street. ``docs/recipes.md`` gives a reason for every number.

Compared with ``paper``: a collision is a body that touches the car, and the car sees where one threatens; observations
in the route's frame, one critic for each role, one value for each pedestrian, pedestrians who decide at the kerb and
keep to it for a second, short rollouts, small minibatches, and a learning rate that falls. In a third of the
environments people meet careless and earlier drivers; in half of them the driver meets people who always go.
"""

from __future__ import annotations

from typing import Final

from jaxwalk.learning.config import GLOBAL, RoleConfig, TrainConfig
from jaxwalk.recipes.experiment import Experiment
from jaxwalk.sim.sim_config import WORLDS

FAST: Final = Experiment(
    recipe="fast",
    train=TrainConfig(
        roles={
            "driver": RoleConfig(
                observes="route-footprint",
                actor_hidden=(256, 256),
                critic_hidden=(256, 256),
                critic_observes=("route-footprint", GLOBAL),
                entropy=0.001,
                epochs=2,
                initial_std=0.5,
                fixed=1 / 4,
                early=1 / 12,
            ),
            "pedestrian": RoleConfig(
                observes="kerb", gated=True, hold=10, critic_observes=("kerb",), entropy=0.003, epochs=1, fixed=1 / 2
            ),
        },
        environments=768,
        steps=64,
        minibatches=32,
        learning_rate=1e-3,
        anneal=True,
        reward_scale=0.1,
    ),
    driver_weights={
        "progress": 0.5,
        "goal": 20.0,
        "collision": -150.0,
        "closeness": -0.4,
        "off_lane": -0.02,
        "misaligned": -0.1,
        "time": -0.06,
    },
    pedestrian_weights={"waited": -0.02, "collision": -100.0},
    sim=WORLDS["paper-footprint"],
)
