"""The file of a sweep: a training, what varies in it, and what counts. ``docs/sweeps.md`` describes it.

This module imports no JAX, so that a wrong file is refused at once.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import TypeAdapter, ValidationError

from jaxwalk.recipes import RECIPES, Experiment, ExperimentFileError
from jaxwalk.recipes.experiment_file import described_experiment, explained_fault, merged_tables, read_table
from jaxwalk.runs.effort import MOST_EPISODES, MOST_SEEDS
from jaxwalk.sim.suites import SUITES
from jaxwalk.sweeps.population import Population, PopulationPlan, check_changeable
from jaxwalk.sweeps.varied import Varied, VariedError, changes_of, grid_of, single_changes, varied_fields

MOST_TRIALS = 100_000
"""Most trials of a sweep."""
CHECKED = 200
"""Number of random combinations of ends that are tried before anything is trained."""
PERCENT = ("goal_rate", "collision_rate", "timeout_rate")
"""Numbers of ``metrics.jsonl`` that say how episodes ended, as shares."""
COUNTED = {"grid": "grid", "pbt": "population"}
"""What decides the number of trials, by samplers that aren't told it."""
FIXED = {
    "seed": "each trial is trained with the same seeds; say how many with seeds",
    "minutes": "trials are compared after equally many updates; set train.updates",
}
"""Fields of a training that can't vary, and why."""


class SweepFileError(ValueError):
    """A file that describes no sweep. The message names file and field, in one line."""


@dataclass(frozen=True)
class SweepObjective:
    """The number by which trials are compared."""

    __pydantic_config__: ClassVar = {"extra": "forbid"}

    metric: str
    """A number of ``metrics.jsonl``, or of an evaluation, such as ``outcomes.goal``."""
    direction: Literal["maximise", "minimise"]
    """Whether more is better, or less."""
    of: Literal["training", "evaluation"] = "training"
    """Where the number is from."""
    episodes: int = 1000
    """Scenarios of an evaluation."""
    seed: int = 77
    """Seed of these scenarios: one for tuning, as the best trial is chosen by it."""
    pedestrians: str = "always-go"
    """The population of an evaluation."""
    suite: str | None = None
    """A suite to evaluate on. None: the maps and the world of the training."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible evaluation."""
        if not 1 <= self.episodes <= MOST_EPISODES:
            raise ValueError(f"episodes must lie in [1, {MOST_EPISODES:,}], not {self.episodes}")
        if not 0 <= self.seed < 2**31:
            raise ValueError(f"seed must lie in [0, 2^31), not {self.seed}")
        if self.suite is not None and self.suite not in SUITES:
            raise ValueError(f"suite must be one of {', '.join(SUITES)}, not {self.suite!r}")
        plain = SweepObjective.__dataclass_fields__
        for name in ("episodes", "seed", "pedestrians", "suite"):
            if self.of == "training" and getattr(self, name) != plain[name].default:
                raise ValueError(f'{name} belongs to an evaluation; write of = "evaluation", or leave it out')

    @property
    def maximised(self) -> bool:
        """Return whether more is better."""
        return self.direction == "maximise"


@dataclass(frozen=True)
class SweepPlan:
    """Everything that a sweep's file says."""

    __pydantic_config__: ClassVar = {"extra": "forbid"}

    objective: SweepObjective
    """The number by which trials are compared."""
    vary: dict[str, Any]
    """What varies, in tables as a training's file has them."""
    training: dict[str, Any] = field(default_factory=dict)
    """What all trials have in common: the content of a training's file."""
    sampler: Literal["tpe", "random", "grid", "pbt"] = "tpe"
    """How a trial's values are chosen."""
    pbt: PopulationPlan | None = None
    """The members of a population and how they change; needed with ``pbt``, and only there."""
    trials: int | None = None
    """Number of trials. None: all of a grid, or of a population."""
    seeds: int = 1
    """Trainings of each trial, with the training's seed, the next one, and so on."""
    sampler_seed: int = 0
    """Seed of the choice of values."""
    prune: bool = False
    """Whether to end trainings that learn worse than the median of earlier ones."""
    path: str = "study.toml"
    """The file, for messages; its folder has the maps and archives that it names."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible field, naming it."""
        if self.trials is not None and not 1 <= self.trials <= MOST_TRIALS:
            raise ValueError(f"trials must lie in [1, {MOST_TRIALS:,}], not {self.trials}")
        if self.trials is None and self.sampler not in COUNTED:
            raise ValueError(f"trials is needed with {self.sampler}")
        if self.trials is not None and self.sampler in COUNTED:
            raise ValueError(f"trials is decided by the {COUNTED[self.sampler]}; leave it out")
        if self.pbt is None and self.sampler == "pbt":
            raise ValueError("pbt is needed with the sampler pbt: a table that says members and generations")
        if self.pbt is not None and self.pbt.count > MOST_TRIALS:
            raise ValueError(f"pbt has {self.pbt.count:,} trials, members x generations; at most {MOST_TRIALS:,}")
        if self.pbt is not None and self.sampler != "pbt":
            raise ValueError(f'pbt goes with sampler = "pbt", not {self.sampler!r}; leave it out')
        if not 1 <= self.seeds <= MOST_SEEDS:
            raise ValueError(f"seeds must lie in [1, {MOST_SEEDS:,}], not {self.seeds}")
        if not 0 <= self.sampler_seed < 2**31:
            raise ValueError(f"sampler_seed must lie in [0, 2^31), not {self.sampler_seed}")
        if self.prune and self.objective.of != "training":
            raise ValueError("prune needs an objective of the training, which is known on the way")
        if self.prune and self.pbt:
            raise ValueError("prune doesn't go with pbt, which replaces the worst members itself; leave it out")
        if not self.vary:
            raise ValueError("vary must name at least one field")

    @cached_property
    def fields(self) -> dict[str, Varied]:
        """Return how each field varies, by its name. Raise VariedError if one can't."""
        return varied_fields(self.vary, "")

    @cached_property
    def grid(self) -> list[dict[str, Any]]:
        """Return the labels of each trial of a grid. Raise VariedError if there is no grid."""
        return grid_of(self.fields)

    @cached_property
    def population(self) -> Population | None:
        """Return the population; None with another sampler."""
        return self.pbt and Population(self.pbt, self.fields, self.objective.maximised, self.sampler_seed)

    @property
    def count(self) -> int:
        """Return the number of trials."""
        if self.pbt:
            return self.pbt.count
        return len(self.grid) if self.trials is None else self.trials

    @property
    def first(self) -> dict[str, Any]:
        """Return the first label of each field."""
        return {name: varied.labels[0] for name, varied in self.fields.items()}

    @property
    def base(self) -> Experiment:
        """Return the training with the first value of each field. Raise ExperimentFileError if it is impossible."""
        try:
            described_experiment(self.training, self.path, RECIPES, within="training.")
        except ExperimentFileError as error:  # what is wrong may be what varies
            try:
                return self.experiment(self.first)
            except ExperimentFileError:
                raise error from None
        return self.experiment(self.first)

    def experiment(self, labels: Mapping[str, Any]) -> Experiment:
        """Return the training with the values of some labels. Raise ExperimentFileError if it is impossible."""
        table = merged_tables(self.training, changes_of(self.fields, labels))
        return described_experiment(table, self.path, RECIPES, within="vary.")

    def training_seeds(self, base: Experiment) -> range:
        """Return the seeds of each trial's trainings."""
        return range(base.seed, base.seed + self.seeds)


def load_sweep(path: str | Path) -> SweepPlan:
    """Return what a TOML file says of a sweep.

    Raises:
        SweepFileError: a field is unknown, missing or impossible, or no training can have the values that it may have.
        ExperimentFileError: it can't be read, or a field of the training is unknown or impossible.
    """
    path = Path(path)
    table = read_table(path)
    try:
        plan = TypeAdapter(SweepPlan).validate_json(json.dumps({**table, "path": str(path)}, default=str), strict=True)
    except ValidationError as error:
        fault = dict(error.errors(include_url=False)[0])
        raise SweepFileError(f"{path}: {_explained(fault)}; correct the file") from None
    _check_fields(plan, table)
    _check_values(plan)
    return plan


def _explained(fault: dict[str, Any]) -> str:
    """Return one pydantic fault in words."""
    if fault["type"] == "missing":
        return f"{'.'.join(map(str, fault['loc']))} is missing"
    parts = {
        "objective": dict.fromkeys(SweepObjective.__dataclass_fields__),
        "pbt": dict.fromkeys(PopulationPlan.__dataclass_fields__),
    }
    return explained_fault(fault, dict.fromkeys(SweepPlan.__dataclass_fields__) | parts)


def _check_fields(plan: SweepPlan, table: Mapping[str, Any]) -> None:
    """Raise SweepFileError unless the fields can vary and the objective's number is one of the training."""
    if "path" in table:
        raise SweepFileError(f"{plan.path}: path: there is no such field; leave it out")
    try:
        _check_vary(plan)
    except VariedError as error:
        raise SweepFileError(f"{plan.path}: vary.{error}; correct the file") from None


def _check_vary(plan: SweepPlan) -> None:
    """Raise VariedError unless the fields can vary, in a grid if that is asked for."""
    for name in FIXED.keys() & plan.fields.keys():
        raise VariedError(f"{name} can't vary: {FIXED[name]}")
    if plan.sampler == "grid":
        grid_of(plan.fields)
        return
    if plan.pbt:
        check_changeable(plan.fields)
    for name, varied in plan.fields.items():
        if getattr(varied, "points", None) is not None:
            raise VariedError(f"{name}: points belongs to a grid; leave it out")


def _check_values(plan: SweepPlan) -> None:
    """Raise ExperimentFileError or SweepFileError for values that no training can have, before anything is done."""
    base = plan.base
    if base.minutes is not None:
        raise SweepFileError(f"{plan.path}: training.minutes: {FIXED['minutes']}; correct the file")
    if plan.pbt and base.train.updates % plan.pbt.generations:
        raise SweepFileError(
            f"{plan.path}: pbt.generations must divide training.train.updates ({base.train.updates:,}), not "
            f"{plan.pbt.generations}; correct the file"
        )
    if base.seed + plan.seeds > 2**32:
        raise SweepFileError(f"{plan.path}: seeds: training.seed + seeds must be at most 2^32; correct the file")
    terms = set(_reward_names(base))
    for labels in single_changes(plan.fields):
        terms |= set(_reward_names(plan.experiment(plan.first | labels)))
    for labels in _combinations(plan):
        plan.experiment(labels)
    if plan.objective.of == "training" and plan.objective.metric not in (*PERCENT, "episode_steps", *sorted(terms)):
        known = ", ".join((*PERCENT, "episode_steps", *sorted(terms)))
        raise SweepFileError(
            f"{plan.path}: objective.metric: there is no {plan.objective.metric!r} of a training; there are {known}"
        )


def _reward_names(experiment: Experiment) -> Iterator[str]:
    """Yield the names of rewards in ``metrics.jsonl``."""
    for role, weights in (("driver", experiment.driver_weights), ("pedestrian", experiment.pedestrian_weights)):
        yield f"reward/{role}"
        yield from (f"reward/{role}/{term}" for term, weight in weights.items() if weight)


def _combinations(plan: SweepPlan) -> Iterator[dict[str, Any]]:
    """Yield combinations to try: all of a small grid, else some of those of ends, at random."""
    if plan.sampler == "grid" and len(plan.grid) <= CHECKED:
        yield from plan.grid
        return
    chance = random.Random(0)
    ends = {name: varied.labels for name, varied in plan.fields.items()}
    for _ in range(CHECKED):
        yield {name: chance.choice(labels) for name, labels in ends.items()}
