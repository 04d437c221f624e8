"""Add a recipe: the world, the rewards and the learner's numbers of a training, under a name."""

from jaxwalk import train
from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.recipes import RECIPES, Experiment

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

trained = train("tiny", seed=1)
print(f"{trained.updates} updates, {trained.steps} steps in {trained.seconds:.0f} s")
