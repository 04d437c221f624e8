"""What is kept of a comparison: a cell for each driver with each population, one JSON document, one row per episode."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from jaxwalk.evaluation.scenarios import BATCH, evaluate_batches
from jaxwalk.evaluation.settings import jaywalk_multiplier, mode
from jaxwalk.interfaces import Policy
from jaxwalk.metrics import OUTCOMES, Estimate, Rate, Rows, Summary, summarise
from jaxwalk.policies.host import DriverError, HostDriver
from jaxwalk.scenarios import Source
from jaxwalk.sim.environment import Street
from jaxwalk.writing import write_whole

SCHEMA = 3
"""Version of the JSON document; it changes when something is added that reports need."""
CONTACT_NAMES = ("", "crosswalk", "jaywalk", "sidewalk")
"""Names of the contact types of `jaxwalk.metrics.outcomes`, by number."""
NAMES = ("driver", "pedestrians")
"""What a row of the file with a row per episode is of, unless told otherwise."""
ENDING = ("outcome", "contact", "impact_speed", "duration")
"""How it went; speeds in m/s, durations in s."""


@dataclass(frozen=True)
class Cell:
    """One driver among one population."""

    driver: str
    """Its name."""
    pedestrians: str
    """The population's name."""
    driver_mode: str
    """``mode`` (takes the likeliest action) or ``sample``."""
    pedestrian_mode: str
    jaywalk_multiplier: float
    summary: Summary
    driver_observes: str
    """Name of the observation set; those in `jaxwalk.sim.observation.HIDDEN` no real car could have."""
    pedestrian_observes: str
    driver_ms_per_step: float | None = None
    """Of a driver that is not JAX: how long it took for a step of its batch, on average [ms]."""

    def as_dict(self) -> dict[str, Any]:
        """Plain dicts, lists and numbers: the headline first, then everything of the summary."""
        outcomes = self.summary[OUTCOMES]
        cost = {} if self.driver_ms_per_step is None else {"driver_ms_per_step": self.driver_ms_per_step}
        return {
            "driver": self.driver,
            "pedestrians": self.pedestrians,
            "driver_mode": self.driver_mode,
            "pedestrian_mode": self.pedestrian_mode,
            "driver_observes": self.driver_observes,
            "pedestrian_observes": self.pedestrian_observes,
            "jaywalk_multiplier": self.jaywalk_multiplier,
            **cost,
            "goal_rate": _with_interval(outcomes.goal),
            "collision_rate": _with_interval(outcomes.collision),
            "timeout_rate": _with_interval(outcomes.timeout),
            "mean_time_to_goal": _with_interval(outcomes.time_to_goal),
            **self.summary.as_dict(),
        }


@dataclass(frozen=True)
class Results:
    """Drivers x populations on one set of scenarios."""

    scenarios: dict[str, Any]
    """What the source says about itself."""
    cells: tuple[Cell, ...]

    def cell(self, driver: str, pedestrians: str) -> Cell:
        """The cell of a driver and a population; raises KeyError if there is none."""
        for cell in self.cells:
            if (cell.driver, cell.pedestrians) == (driver, pedestrians):
                return cell
        raise KeyError(f"no cell for {driver} among {pedestrians}")

    def as_dict(self) -> dict[str, Any]:
        """The document: nothing in it but ``driver_ms_per_step`` depends on when or where it was made."""
        return {
            "schema": SCHEMA,
            "scenarios": self.scenarios,
            "cells": [cell.as_dict() for cell in self.cells],
        }

    def to_json(self) -> str:
        """The document as text; the same results give the same text. What does not exist is null."""
        return json.dumps(self.as_dict(), indent=2, allow_nan=False)


class Stopped(ValueError):
    """A driver failed in the middle of a comparison. The message is the driver's error's."""

    def __init__(self, message: str, rows: dict[tuple[str, str], Rows]) -> None:
        """``rows``: what had been evaluated until then, in whole batches."""
        super().__init__(message)
        self.rows = rows


def compare(
    street: Street,
    drivers: Mapping[str, Policy],
    populations: Mapping[str, Policy],
    source: Source,
    *,
    batch: int = BATCH,
    progress: Callable[[str, str, int, int], None] | None = None,
) -> tuple[Results, dict[tuple[str, str], Rows]]:
    """Every driver among every population, on the same scenarios.

    Args:
        street: the world.
        drivers: by name.
        populations: pedestrian policies by name.
        source: the scenarios.
        batch: episodes played at once.
        progress: called with driver, population, episodes played of the cell, and all.

    Returns:
        The results, and the rows of each (driver, population).

    Raises:
        ValueError: ``batch`` is below 1.
        Stopped: a driver that is not JAX failed; the error has the rows so far.
    """
    cells, rows = [], {}
    for driver_name, driver in drivers.items():
        for name, pedestrians in populations.items():
            tell = partial(progress, driver_name, name) if progress is not None else None
            policies = {"driver": driver, "pedestrian": pedestrians}
            batches = evaluate_batches(street, policies, source, batch=batch, progress=tell)
            before = _cost(driver)
            measured, failure = _joined(batches)
            if measured is not None:
                rows[driver_name, name] = measured
            if measured is None or failure is not None:
                raise Stopped(str(failure), rows) from failure
            cost = _ms_per_step(_cost(driver) - before)
            cells.append(make_cell(street, driver_name, driver, name, pedestrians, measured, cost))
    return Results(source.describe(), tuple(cells)), rows


def _joined(batches: Iterable[Rows]) -> tuple[Rows | None, DriverError | None]:
    """The rows of all batches, or of those before the driver failed (None: of no batch), and how it failed."""
    parts, failure = [], None
    try:
        for part in batches:
            parts.append(part)
    except DriverError as error:
        failure = error
    return Rows.join(parts) if parts else None, failure


def _cost(driver: Policy) -> Float[np.ndarray, "2"]:
    """Seconds that a driver took until now, and for how many steps; zeros for one that is compiled with the rest."""
    spent = (driver.seconds_spent, driver.steps_made) if isinstance(driver, HostDriver) else (0, 0)
    return np.array(spent, float)


def _ms_per_step(cost: Float[np.ndarray, "2"]) -> float | None:
    seconds, steps = cost.tolist()
    return round(1000 * seconds / steps, 3) if steps else None


def make_cell(
    street: Street,
    driver_name: str,
    driver: Policy,
    population_name: str,
    pedestrians: Policy,
    rows: Rows,
    driver_ms_per_step: float | None = None,
) -> Cell:
    """The cell of rows that `evaluate` gave for these policies on this street."""
    return Cell(
        driver=driver_name,
        pedestrians=population_name,
        driver_mode=mode(driver),
        pedestrian_mode=mode(pedestrians),
        jaywalk_multiplier=jaywalk_multiplier(street),
        summary=summarise(rows),
        driver_observes=driver.view.name,
        pedestrian_observes=pedestrians.view.name,
        driver_ms_per_step=driver_ms_per_step,
    )


def write_rows(path: str | Path, cells: Iterable[tuple[Any, ...]], *, names: tuple[str, ...] = NAMES) -> None:
    """Write a CSV file with a row per episode; it appears whole or not at all.

    The columns are ``scenario``, the names and `ENDING`; without a collision, contact and impact speed are empty.

    Args:
        path: the file.
        cells: for each, a value for every name (None: empty), and last its `Rows`.
        names: columns that tell cells apart.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("scenario", *names, *ENDING))
    for *values, rows in cells:
        writer.writerows(_episode_rows(values, rows))
    write_whole(path, text.getvalue())


def _episode_rows(values: list[Any], rows: Rows) -> Iterable[tuple[Any, ...]]:
    table, step = rows[OUTCOMES], Decimal(f"{rows.dt:.6g}").normalize().as_tuple()
    digits = max(1, -int(step.exponent))  # as many as a step has
    outcome = np.where(table.goal, "goal", np.where(table.collision, "collision", "timeout"))
    for i in range(len(outcome)):
        contact = CONTACT_NAMES[table.contact[i]]
        impact = f"{table.impact_speed[i]:.3f}" if table.collision[i] else ""
        duration = f"{table.steps[i] * rows.dt:.{digits}f}"
        yield int(table.scenario[i]), *values, str(outcome[i]), contact, impact, duration


def _with_interval(number: Rate | Estimate) -> dict[str, float | None]:
    return {"value": number.value, "low": number.low, "high": number.high}
