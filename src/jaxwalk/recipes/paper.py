"""The recipe ``paper``: the paper's section III-B and Table II. ``docs/recipes.md`` says what the paper leaves open.

One critic on the global state, one blended reward and one advantage for everybody.
"""

from __future__ import annotations

from typing import Final

from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.recipes.experiment import Experiment

PAPER: Final = Experiment(
    recipe="paper",
    train=TrainConfig(
        roles={
            "driver": RoleConfig(actor_hidden=(256, 256), entropy=0.01, noise="tanh"),
            "pedestrian": RoleConfig(actor_hidden=(128, 128), entropy=0.03),
        },
        credit="shared",
    ),
    driver_weights={
        "crow_progress": 1.0,
        "goal": 50.0,
        "collision": -50.0,
        "crosswalk_speeding": -0.3,
        "jaywalker_speeding": -0.3,
        "off_lane": -0.05,
        "misaligned": -0.1,
    },
    pedestrian_weights={"walked": 2.0, "arrival": 5.0, "collision": -25.0, "waiting": 0.3},
)
