"""What a metric is, and the rows that metrics measure: ``docs/extending.md#a-metric`` shows how to add one.

A *finding* is computed from recorded episodes once, for all metrics that need it. A *table* is a finding that is kept.
A *metric* is a table with numbers: columns that are resampled by episode, and a summary of rows and sums. Rows may be
too many for memory, so a summary adds up (`Rows.total`) or lists (`Rows.values`) what it finds in each chunk of them.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import Any, Generic, TypeVar, get_type_hints

import jax
import numpy as np
from jaxtyping import Float, Shaped

from jaxwalk.metrics.values import Values
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Ghosts, Trajectory

T = TypeVar("T")
Numbers = TypeVar("Numbers")


@dataclass(frozen=True)
class Recording:
    """Recorded episodes, and the findings computed from them."""

    trajectory: Trajectory
    ghosts: Ghosts | None
    """People that the cars could not see, for the placebo."""
    config: SimConfig
    """Says when a car is moving and what a touch is."""
    found: dict[str, Any]
    """Findings by name."""

    def __getitem__(self, finding: Finding[T]) -> T:
        """Return a finding. Raise KeyError if no metric has declared it in its ``needs``."""
        if finding.name not in self.found:
            raise KeyError(f"{finding.name} has not been measured: name it in the needs of the metric that reads it")
        return self.found[finding.name]


@dataclass(frozen=True, kw_only=True)
class Finding(Generic[T]):
    """Something that is computed from recorded episodes, once for all metrics that need it."""

    name: str
    measure: Callable[[Recording], T]
    needs: tuple[Finding[Any], ...] = ()
    """Findings that ``measure``, ``columns`` or ``summarise`` read."""


class MetricTable(Finding[T]):
    """A finding that `Rows` keeps.

    ``measure`` returns a frozen dataclass of NumPy columns of one length. A column named ``episode`` holds rows of
    episodes; a table without one has a row per episode, or is parallel to a table that has it.
    """


@dataclass(frozen=True, kw_only=True)
class Metric(MetricTable[T], Generic[T, Numbers]):
    """A table with numbers. ``name`` is also the metric's key in the summary and in its JSON."""

    summarise: Callable[[Rows, Sums], Numbers]
    """Its annotated result is the type of the numbers: frozen dataclasses and tuples of numbers and None. It reads the
    rows by `Rows.total`, `Rows.values` and `Rows.chunks` only. Like ``columns``, it asks a table for columns by their
    names, not by ``vars``: those of parts are read from files then."""
    columns: Callable[[Rows], Mapping[str, Shaped[np.ndarray, "episode ..."]]] = lambda rows: {}
    """The columns that are resampled by episode; `Sums` has their sums by the same names."""
    headline: bool = False
    """Whether the numbers come before those of other metrics in the summary."""

    @property
    def numbers(self) -> Any:
        """The type of the metric's numbers."""
        return get_type_hints(self.summarise)["return"]


@dataclass(frozen=True)
class NoRows:
    """The table of a metric that only reads other metrics' tables."""


@dataclass(frozen=True)
class Rows:
    """The tables of all metrics. ``rows[OUTCOMES]`` is the table of `OUTCOMES`, with its type."""

    dt: float
    """Duration of a step [s]."""
    episodes: int
    metrics: tuple[Metric[Any, Any], ...]
    """All metrics, in the order in which their columns are resampled."""
    tables: Mapping[str, Any]
    """Tables by the name of their metric."""
    maps: Shaped[np.ndarray, "episode"] | None = None
    """Name of the map of each episode; None if it isn't known."""

    def __getitem__(self, table: MetricTable[T]) -> T:
        """Return a table. Raise KeyError if it was not measured."""
        if table.name not in self.tables:
            raise KeyError(f"{table.name} was not measured; there are {', '.join(self.tables)}")
        return self.tables[table.name]

    def chunks(self) -> Iterator[Rows]:
        """Yield the rows of some episodes at a time, in their order. Rows in memory are one chunk."""
        yield self

    def total(self, formula: Callable[[Rows], T]) -> T:
        """Return the sum over all chunks of a formula's whole numbers: one, an array, or a dict of them."""
        return added_up(map(formula, self.chunks()))

    def values(self, formula: Callable[[Rows], Shaped[np.ndarray, "_"]]) -> Values:
        """Return a formula's values in all chunks. They are computed whenever they are asked for."""
        return Values(lambda: map(formula, self.chunks()))

    def having(self, table: MetricTable[T], found: T) -> Rows:
        """Return the same rows with this table in place of the measured one."""
        return replace(self, tables={**self.tables, table.name: found})

    @staticmethod
    def join(parts: Sequence[Rows]) -> Rows:
        """Return the rows of all parts, as if all their episodes had been measured together.

        Raises:
            ValueError: there are no parts, or their step durations or metrics differ.
        """
        if not parts:
            raise ValueError("there are no rows to join")
        first = parts[0]
        steps = {part.dt for part in parts}
        if len(steps) > 1:
            raise ValueError(f"rows of different step durations cannot be joined: {sorted(steps)} s")
        if any(part.metrics != first.metrics for part in parts):
            raise ValueError("rows of different metrics cannot be joined")
        offsets = np.cumsum([0, *(part.episodes for part in parts[:-1])])
        tables = {name: _join_tables([part.tables[name] for part in parts], offsets) for name in first.tables}
        maps = [part.maps for part in parts if part.maps is not None]
        known = np.concatenate(maps) if len(maps) == len(parts) else None
        return Rows(first.dt, sum(part.episodes for part in parts), first.metrics, tables, known)


def added_up(found: Iterable[T]) -> T:
    """Return the sum of numbers, of arrays, or of dicts of them; there is at least one."""
    return reduce(partial(jax.tree.map, operator.add), found)


def episodes_with(
    rows: Rows, columns: Callable[[Rows], Mapping[str, Shaped[np.ndarray, "episode ..."]]]
) -> dict[str, Any]:
    """Return in how many episodes each column isn't 0: a number, or an array for a column with further axes."""
    return rows.total(lambda chunk: {name: (found != 0).sum(axis=0) for name, found in columns(chunk).items()})


def _join_tables(tables: Sequence[T], offsets: np.ndarray) -> T:
    """Join tables one below the other; ``episode`` columns are shifted by the offsets."""
    columns = {}
    for name in vars(tables[0]):
        parts = [getattr(table, name) for table in tables]
        if name == "episode":
            parts = [(part + offset).astype(part.dtype) for part, offset in zip(parts, offsets, strict=True)]
        columns[name] = np.concatenate(parts)
    return type(tables[0])(**columns)


@dataclass(frozen=True)
class Sums:
    """The columns of all metrics, summed over all episodes (row 0) and over episodes drawn with replacement (the rest).

    All metrics see the same draws.
    """

    resamples: int
    seed: int
    """Seed of the draws."""
    by_metric: Mapping[str, Mapping[str, Float[np.ndarray, "draw ..."]]]

    def __getitem__(self, metric: Metric[Any, Any]) -> Mapping[str, Float[np.ndarray, "draw ..."]]:
        """Return the sums of a metric's columns, by name."""
        return self.by_metric[metric.name]


def with_needs(findings: Iterable[Finding[Any]]) -> tuple[Finding[Any], ...]:
    """Return the findings and everything that they need; each comes after its own needs.

    Raises:
        ValueError: two findings have the same name.
    """
    ordered: dict[str, Finding[Any]] = {}

    def add(finding: Finding[Any]) -> None:
        for need in finding.needs:
            add(need)
        if ordered.setdefault(finding.name, finding) != finding:
            raise ValueError(f"two metrics are named {finding.name}")

    for finding in findings:
        add(finding)
    return tuple(ordered.values())
