"""From trajectories to rows to numbers. ``docs/metrics.md`` has the formulas."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any, TypeVar

import pydantic
from pydantic_core import core_schema

from jaxwalk.metrics.metric import Metric, MetricTable, Numbers, Recording, Rows, Sums, with_needs
from jaxwalk.metrics.registry import METRICS
from jaxwalk.metrics.statistics import RESAMPLES, episode_sums
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Ghosts, Trajectory

T = TypeVar("T")


@dataclass(frozen=True)
class Summary:
    """The numbers of all metrics, with 95 % intervals and counts; what does not exist is None.

    ``summary[OUTCOMES]`` has the numbers of `OUTCOMES`, with their type.
    """

    episodes: int
    numbers: Mapping[str, Any]
    """By name of the metric."""

    def __getitem__(self, metric: Metric[T, Numbers]) -> Numbers:
        """Return the numbers of a metric; raises KeyError if it was not measured."""
        if metric.name not in self.numbers:
            raise KeyError(f"{metric.name} was not measured; there are {', '.join(self.numbers)}")
        return self.numbers[metric.name]

    def as_dict(self) -> dict[str, Any]:
        """Return plain nested dicts, tuples, numbers and None: ready for JSON."""
        return {"episodes": self.episodes, **asdict(self)["numbers"]}

    @staticmethod
    def from_dict(document: Mapping[str, Any], *, metrics: Sequence[Metric[Any, Any]] = METRICS) -> Summary:
        """Return the summary that `as_dict` made the document of, also after a way through JSON.

        Raises:
            ValueError: a part is unknown, missing or of another type; the message names the first such part.
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
        """Let a type that has a summary be read by pydantic: a summary is read from what `as_dict` gives."""
        return core_schema.no_info_after_validator_function(_summary, handler.generate_schema(_model(METRICS)))


def _summary(found: pydantic.BaseModel) -> Summary:
    """Return the summary that a document of `_model` holds."""
    numbers = dict(vars(found))
    return Summary(numbers.pop("episodes"), numbers)


@cache
def _model(metrics: tuple[Metric[Any, Any], ...]) -> type[pydantic.BaseModel]:
    """Return the type of a document with the numbers of these metrics and nothing else."""
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
    """Return the rows of all episodes of a trajectory; ``Rows.join`` joins those of several.

    Args:
        trajectory: recorded episodes; frames after their ``length`` are ignored.
        ghosts: people whom the cars could not see, for the placebo.
        config: when a car is moving, and what is a touch (default: `SimConfig`'s).
        metrics: what to measure; metrics that these need are measured too.

    Raises:
        ValueError: an episode is longer than the trajectory, or two metrics have one name.
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
    """Return the numbers of all metrics of the rows.

    Args:
        rows: what `measure` gave.
        resamples: of the bootstrap over episodes.
        seed: of the bootstrap's draws.
    """
    columns = {metric.name: metric.columns(rows) for metric in rows.metrics}
    flat = {(name, column): values for name, found in columns.items() for column, values in found.items()}
    summed = episode_sums(flat, resamples=resamples, seed=seed) if flat else {}
    by_metric = {name: {column: summed[name, column] for column in found} for name, found in columns.items()}
    sums = Sums(resamples, seed, by_metric)
    ordered = sorted(rows.metrics, key=lambda metric: not metric.headline)
    return Summary(rows.episodes, {metric.name: metric.summarise(rows, sums) for metric in ordered})
