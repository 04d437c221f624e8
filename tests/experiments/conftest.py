"""A training so small that its time is all compiling, which is done once."""

import io
from dataclasses import replace

import pytest
from rich.console import Console

SMALL = {"environments": 8, "steps": 8, "minibatches": 2, "updates": 6}


@pytest.fixture(scope="session")
def tiny():
    """An experiment of 6 updates of 8 environments x 8 steps."""
    from jaxwalk.experiments.recipes import RECIPES, with_training

    experiment = RECIPES["fast"]
    roles = {
        role: replace(experiment.train.role(role), actor_hidden=(8,), critic_hidden=(8,), epochs=1)
        for role in ("driver", "pedestrian")
    }
    return with_training(experiment, **SMALL, **roles)


@pytest.fixture
def quiet():
    """A console that nobody reads."""
    return Console(file=io.StringIO(), width=100)


@pytest.fixture(scope="session")
def whole(tiny, tmp_path_factory):
    """The run of an uninterrupted training."""
    from jaxwalk.experiments.runs import Run
    from jaxwalk.experiments.training import train

    run = Run.create(tmp_path_factory.mktemp("runs") / "whole", tiny)
    train(run, console=Console(file=io.StringIO()))
    return run
