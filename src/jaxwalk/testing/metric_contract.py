"""What a metric must do, so that evaluations can join, summarise and write it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from jaxwalk.evaluation.stored_rows import StoredTable
from jaxwalk.metrics import Rows, Summary, measure, summarise
from jaxwalk.metrics.metric import Metric
from jaxwalk.sim.trajectory import Ghosts, Trajectory
from jaxwalk.testing.requirement import ContractError, require, same

RESAMPLES = 20
"""Bootstrap draws of the check: enough to run the code."""


def check_metric(metric: Metric[Any, Any], trajectory: Trajectory, ghosts: Ghosts | None = None) -> None:
    """Measure recorded episodes by a metric, and check everything that others rely on.

    Args:
        metric: what to check.
        trajectory: recorded episodes.
        ghosts: people that the cars could not see, if the metric needs them.

    Raises:
        ContractError: something doesn't hold; the message says what.
    """
    rows = measure(trajectory, ghosts, metrics=(metric,))
    table = rows[metric]
    again = measure(trajectory, ghosts, metrics=(metric,))[metric]
    require(same(vars(table), vars(again)), f"{metric.name}: measure must be deterministic")
    lengths = {name: len(column) for name, column in vars(table).items()}
    require(len(set(lengths.values())) <= 1, f"{metric.name}: columns of a table have one length, not {lengths}")
    _check_summary(metric, rows)
    twice = Rows.join([rows, rows])
    doubled = summarise(twice, resamples=RESAMPLES)
    require(doubled.episodes == 2 * rows.episodes, f"{metric.name}: joined rows must have the episodes of both")
    _check_chunks(metric, rows)


@dataclass(frozen=True)
class _InChunks(Rows):
    """Rows that are in their chunk only, as those of merged parts are."""

    chunk: Rows | None = None

    def chunks(self) -> Iterator[Rows]:
        if self.chunk is not None:
            yield self.chunk


def _check_chunks(metric: Metric[Any, Any], rows: Rows) -> None:
    tables = {name: StoredTable(table, partial(getattr, table)) for name, table in rows.tables.items()}
    in_chunks = _InChunks(rows.dt, rows.episodes, rows.metrics, {}, chunk=replace(rows, tables=tables))
    try:
        found = summarise(in_chunks, resamples=RESAMPLES)
    except (KeyError, TypeError) as error:
        rule = "summarise must read rows by `Rows.total`, `Rows.values` or `Rows.chunks`, and columns by their names"
        raise ContractError(f"{metric.name}: {rule} ({error.args[0]})") from error
    same_numbers = found[metric] == summarise(rows, resamples=RESAMPLES)[metric]
    require(same_numbers, f"{metric.name}: its numbers must be the same for rows in chunks")


def _check_summary(metric: Metric[Any, Any], rows: Rows) -> None:
    for name, column in metric.columns(rows).items():
        rule = f"column {name} must have a row for each of {rows.episodes} episodes, not {len(column)}"
        require(len(column) == rows.episodes, f"{metric.name}: {rule}")
    found = summarise(rows, resamples=RESAMPLES)
    try:
        text = json.dumps(found.as_dict(), allow_nan=False)
    except (TypeError, ValueError) as error:
        rule = "its numbers must be plain JSON, None where there is none"
        raise ContractError(f"{metric.name}: {rule} ({error})") from error
    try:
        read = Summary.from_dict(json.loads(text), metrics=rows.metrics)
    except ValueError as error:
        raise ContractError(f"{metric.name}: its numbers must have the types that it declares ({error})") from error
    require(read[metric] == found[metric], f"{metric.name}: its numbers must be the same after a way through JSON")
