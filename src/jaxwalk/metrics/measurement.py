"""Measure the rows of trajectories, and summarise rows to numbers. ``docs/metrics.md`` has the formulas."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from itertools import chain
from typing import Any, TypeVar

import numpy as np
import pydantic
from pydantic_core import core_schema

from jaxwalk.metrics.metric import Metric, MetricTable, Numbers, Recording, Rows, Sums, with_needs
from jaxwalk.metrics.registry import METRICS
from jaxwalk.metrics.statistics import RESAMPLES, sums_over_chunks
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Ghosts, Trajectory

T = TypeVar("T")


@dataclass(frozen=True)
class Summary:
    """The numbers of all metrics, with 95 % intervals and counts; None stands for a number that does not exist.

    ``summary[OUTCOMES]`` has the numbers of `OUTCOMES`, with their types.
    """

    episodes: int
    numbers: Mapping[str, Any]
    """Numbers by the metric's name."""

    def __getitem__(self, metric: Metric[T, Numbers]) -> Numbers:
        """Return the numbers of a metric. Raise KeyError if it was not measured."""
        if metric.name not in self.numbers:
            raise KeyError(f"{metric.name} was not measured; there are {', '.join(self.numbers)}")
        return self.numbers[metric.name]

    def as_dict(self) -> dict[str, Any]:
        """Return plain nested dicts, tuples, numbers and None: ready for JSON."""
        return {"episodes": self.episodes, **asdict(self)["numbers"]}

    @staticmethod
    def from_dict(document: Mapping[str, Any], *, metrics: Sequence[Metric[Any, Any]] = METRICS) -> Summary:
        """Return the summary whose `as_dict` is this document, also after saving it as JSON and reading it again.

        Raises:
            ValueError: a part is unknown, missing or has the wrong type; the message names the first such part.
        """
        try:
            found = _model(tuple(metrics)).model_validate_json(json.dumps(document), strict=True)
        except pydantic.ValidationError as error:
            fault = error.errors()[0]
            raise ValueError(f"{'.'.join(map(str, fault['loc']))}: {fault['msg']}") from None
        return _summary(found)

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: Any, handler: pydantic.GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Let pydantic read summaries as parts of other types, from what `as_dict` returns."""
        return core_schema.no_info_after_validator_function(_summary, handler.generate_schema(_model(METRICS)))


def _summary(found: pydantic.BaseModel) -> Summary:
    """Return the summary in a document of `_model`."""
    numbers = dict(vars(found))
    return Summary(numbers.pop("episodes"), numbers)


@cache
def _model(metrics: tuple[Metric[Any, Any], ...]) -> type[pydantic.BaseModel]:
    """Return the type of a document that has the numbers of these metrics and nothing else."""
    ordered = sorted(metrics, key=lambda metric: not metric.headline)
    parts: dict[str, Any] = {metric.name: (metric.numbers, ...) for metric in ordered}
    return pydantic.create_model("Document", __config__={"extra": "forbid"}, episodes=(int, ...), **parts)


def measure(
    trajectory: Trajectory,
    ghosts: Ghosts | None = None,
    *,
    config: SimConfig | None = None,
    metrics: Sequence[Metric[Any, Any]] = METRICS,
) -> Rows:
    """Return the rows of all episodes of a trajectory; ``Rows.join`` joins the rows of several trajectories.

    Args:
        trajectory: recorded episodes; frames after their ``length`` are ignored.
        ghosts: people that the cars could not see, for the placebo.
        config: says when a car is moving and what a touch is (default: that of `SimConfig`).
        metrics: what to measure; the metrics that these need are measured too.

    Raises:
        ValueError: an episode is longer than the trajectory, or two metrics have the same name.
    """
    frames = len(trajectory.car_x)
    if trajectory.length.size and trajectory.length.max() >= frames:
        raise ValueError(f"length {trajectory.length.max()} needs one frame more than the trajectory's {frames}")
    findings = with_needs(metrics)
    recording = Recording(trajectory, ghosts, config or SimConfig(), found={})
    for finding in findings:
        recording.found[finding.name] = finding.measure(recording)
    return Rows(
        dt=float(trajectory.dt),
        episodes=len(trajectory.length),
        metrics=tuple(dict.fromkeys([*metrics, *(x for x in findings if isinstance(x, Metric))])),
        tables={x.name: recording[x] for x in findings if isinstance(x, MetricTable)},
    )


def summarise(rows: Rows, *, resamples: int = RESAMPLES, seed: int = 0) -> Summary:
    """Return the numbers of all metrics.

    Args:
        rows: measured episodes.
        resamples: number of bootstrap resamples over episodes.
        seed: seed of the bootstrap.
    """
    sums = _sums(rows, resamples, seed)
    ordered = sorted(rows.metrics, key=lambda metric: not metric.headline)
    return Summary(rows.episodes, {metric.name: metric.summarise(rows, sums) for metric in ordered})


def _sums(rows: Rows, resamples: int, seed: int) -> Sums:
    columns = map(_columns, rows.chunks())
    first = next(columns)
    all_of_them = chain([first], columns)
    summed = sums_over_chunks(all_of_them, rows.episodes, resamples=resamples, seed=seed) if first else {}
    by_metric: dict[str, dict[str, np.ndarray]] = {metric.name: {} for metric in rows.metrics}
    for (metric, column), found in summed.items():
        by_metric[metric][column] = found
    return Sums(resamples, seed, by_metric)


def _columns(rows: Rows) -> dict[tuple[str, str], np.ndarray]:
    """Return the columns that are resampled by episode, by the names of metric and column."""
    return {(metric.name, name): column for metric in rows.metrics for name, column in metric.columns(rows).items()}
