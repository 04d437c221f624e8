"""Add a recipe: the world, the rewards and the learner's numbers of a training, under a name."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.recipes import RECIPES, Experiment
from jaxwalk.runs.folder import Run
from jaxwalk.runs.training import train

TINY = Experiment(
    recipe="tiny",
    train=TrainConfig(
        roles={
            "driver": RoleConfig(observes="route", actor_hidden=(16,), critic_hidden=(16,), critic_observes=("route",)),
            "pedestrian": RoleConfig(observes="kerb", gated=True, hold=10, critic_observes=("kerb",)),
        },
        environments=16,
        steps=8,
        minibatches=2,
        updates=2,
    ),
    driver_weights={"progress": 0.5, "collision": -100.0},
    pedestrian_weights={"waited": -0.02, "collision": -100.0},
)
RECIPES[TINY.recipe] = TINY

with TemporaryDirectory() as folder:
    experiment = replace(RECIPES["tiny"], seed=1)
    trained = train(Run.create(Path(folder) / "run", experiment))
    print(f"{trained.updates} updates, {trained.steps} steps in {trained.seconds:.0f} s")
