"""What a training is: the world, the pay and the learner's numbers, under a name. ``docs/recipes.md`` gives reasons.

No JAX import, so that a command line starts quickly.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from jaxwalk.learning.config import FAST, PAPER, TrainConfig, own_environments
from jaxwalk.sim.sim_config import JAYWALK_MULTIPLIER, SimConfig
from jaxwalk.sim.weights import DRIVER_WEIGHTS, PEDESTRIAN_WEIGHTS


@dataclass(frozen=True)
class Experiment:
    """One training, complete: with it, a run can be repeated. Ablations are functions Experiment -> Experiment."""

    __pydantic_config__: ClassVar = {"extra": "forbid"}
    """When read from a file, unknown fields are errors, here and in all parts."""

    recipe: str
    """Name of the recipe that it started from."""
    train: TrainConfig
    """How the learner learns."""
    driver_weights: dict[str, float]
    """What the car is paid for (`jaxwalk.sim.reward.DRIVER_TERMS`)."""
    pedestrian_weights: dict[str, float]
    """What a pedestrian is paid for (`jaxwalk.sim.reward.PEDESTRIAN_TERMS`)."""
    maps: tuple[str, ...] = ("paper",)
    """Bundled maps or map files; a scenario draws one."""
    jaywalk_multiplier: float = JAYWALK_MULTIPLIER
    """P(jaywalk | decision) = jaywalking tendency x this."""
    sim: SimConfig = field(default_factory=SimConfig)
    """The world's rules."""
    seed: int = 0
    """Of networks, scenarios and actions."""
    minutes: float | None = None
    """Training is yet to be planned: as many updates as fit into so many minutes. None: `TrainConfig.updates` it is."""

    def __post_init__(self) -> None:
        """Refuse what no environment could be made of."""
        if not self.maps:
            raise ValueError("maps must name at least one map")
        if not 0 <= self.seed < 2**32:
            raise ValueError(f"seed must lie in [0, 2^32), not {self.seed}")
        if not 0 <= self.jaywalk_multiplier < float("inf"):
            raise ValueError(f"jaywalk_multiplier must be 0 or more, not {self.jaywalk_multiplier}")
        if self.minutes is not None and not 0 < self.minutes < float("inf"):
            raise ValueError(f"minutes must be above 0, not {self.minutes}")

    @property
    def single_agent(self) -> bool:
        """Only the car learns; pedestrians always go."""
        return not self.train.roles["pedestrian"].learns

    @property
    def steps_per_update(self) -> int:
        """Environment steps in one update."""
        return self.train.environments * self.train.steps


RECIPES: dict[str, Experiment] = {
    name: Experiment(
        recipe=name,
        train=train,
        driver_weights=DRIVER_WEIGHTS[name],
        pedestrian_weights=PEDESTRIAN_WEIGHTS[name],
    )
    for name, train in {"fast": FAST, "paper": PAPER}.items()
}
"""The recipes, by name."""


def single_agent(experiment: Experiment) -> Experiment:
    """The same, but the car learns alone, among pedestrians who always go: from as many environments as before.

    Without pedestrians to teach, nobody needs other drivers.
    """
    train = experiment.train
    own = own_environments(train, "driver")
    roles = {
        "driver": replace(train.roles["driver"], fixed=0.0, early=0.0),
        "pedestrian": replace(train.roles["pedestrian"], fixed=1.0, early=0.0),
    }
    return replace(experiment, train=replace(train, environments=own, roles=roles))


def with_training(experiment: Experiment, **changes: Any) -> Experiment:
    """The same with other fields of its `TrainConfig`; a change to None is none."""
    changes = {name: value for name, value in changes.items() if value is not None}
    return replace(experiment, train=replace(experiment.train, **changes))
