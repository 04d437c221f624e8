"""The definition of a training: the world, the weights of the rewards and the learner's numbers, under a name.

This module imports no JAX, so that a command line starts quickly.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from jaxwalk.learning.config import CostLimit, TrainConfig, own_environments
from jaxwalk.sim.sim_config import SimConfig, check_multiplier

LONGEST = 1_000_000
"""Longest time for which a training can be planned [min]: two years."""


@dataclass(frozen=True)
class Experiment:
    """Everything needed to repeat a training. An ablation is a function Experiment -> Experiment."""

    __pydantic_config__: ClassVar = {"extra": "forbid"}
    """Unknown fields of a file are errors, here and in all parts."""

    recipe: str
    """Name of the recipe that it started from."""
    train: TrainConfig
    """How the learner learns."""
    driver_weights: dict[str, float]
    """The weight of each of the car's reward terms (`jaxwalk.sim.reward.DRIVER_TERMS`)."""
    pedestrian_weights: dict[str, float]
    """The weight of each of a pedestrian's reward terms (`jaxwalk.sim.reward.PEDESTRIAN_TERMS`)."""
    maps: tuple[str, ...] = ("paper",)
    """Bundled maps or map files; each scenario takes place on one of them."""
    jaywalk_multiplier: float | None = None
    """Replaces that of ``sim`` in the training; evaluations have the world's. None: the world's."""
    sim: SimConfig = field(default_factory=SimConfig)
    """The rules of the world."""
    crowds: tuple[int, ...] = ()
    """Numbers of people in an episode: updates take turns with them. Empty: always ``sim.pedestrians``."""
    archives: tuple[str, ...] = ()
    """Files of scenarios, or folders of searches, that are mixed in (``docs/learning-from-failures.md``)."""
    archive_share: float = 0.25
    """Share of the episodes with an archive's number of people that begin with a scenario of ``archives``."""
    seed: int = 0
    """The seed of networks, scenarios and actions."""
    minutes: float | None = None
    """Time [min] for which the training is planned when it starts. None: `TrainConfig.updates` is the plan."""

    def __post_init__(self) -> None:
        """Raise ValueError for values with which no environment can be made, naming the field."""
        if not self.maps:
            raise ValueError("maps must name at least one map")
        if not 0 <= self.seed < 2**32:
            raise ValueError(f"seed must lie in [0, 2^32), not {self.seed}")
        if self.jaywalk_multiplier is not None:
            check_multiplier(self.jaywalk_multiplier)
        if self.minutes is not None and not 0 < self.minutes <= LONGEST:
            raise ValueError(f"minutes must be above 0 and at most {LONGEST:,}, not {self.minutes:g}")
        if not 0 < self.archive_share <= 1:
            raise ValueError(f"archive_share must be above 0 and at most 1, not {self.archive_share:g}")
        for people in self.crowds:
            replace(self.sim, pedestrians=people)  # it refuses an impossible number

    @property
    def single_agent(self) -> bool:
        """Return whether only the car learns; pedestrians then always go."""
        return not self.train.roles["pedestrian"].learns

    @property
    def steps_per_update(self) -> int:
        """Return the number of environment steps in one update."""
        return self.train.environments * self.train.steps


def single_agent(experiment: Experiment) -> Experiment:
    """Return the same experiment with the car as the only learner, among pedestrians who always go.

    The car learns from as many environments as before. Other drivers are left out: only learning pedestrians need them.
    """
    train = experiment.train
    own = own_environments(train, "driver")
    roles = {
        "driver": replace(train.roles["driver"], fixed=0.0, early=0.0),
        "pedestrian": replace(train.roles["pedestrian"], fixed=1.0, early=0.0),
    }
    return replace(experiment, train=replace(train, environments=own, roles=roles))


def with_training(experiment: Experiment, **changes: Any) -> Experiment:
    """Return the same experiment with other values in its `TrainConfig`. None leaves a field unchanged."""
    changes = {name: value for name, value in changes.items() if value is not None}
    return replace(experiment, train=replace(experiment.train, **changes))


def with_limits(experiment: Experiment, *limits: CostLimit) -> Experiment:
    """Return the same experiment with these limits of the car's costs."""
    roles = experiment.train.roles
    return with_training(experiment, roles={**roles, "driver": replace(roles["driver"], limits=limits)})
