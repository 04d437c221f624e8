"""The results of an evaluation: a cell for each driver among each population, and one JSON document of all cells."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, ClassVar

import jax
import numpy as np
from jaxtyping import Float

from jaxwalk.evaluation.avoidable import CounterfactualSummary
from jaxwalk.evaluation.batches import evaluate_batches
from jaxwalk.evaluation.broken import ActionError
from jaxwalk.evaluation.document_parts import (
    ComparedEnding,
    EvaluationOptions,
    Interval,
    PairedDelay,
    PairedSeeds,
    PolicyOrigin,
    ScenarioSet,
    SeedNumbers,
    StreetOrigin,
)
from jaxwalk.evaluation.map_rates import MapRates, rates_by_map
from jaxwalk.evaluation.settings import acts_by, jaywalk_multiplier
from jaxwalk.evaluation.shield_effects import ShieldEffect
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.metrics import DELAY, OUTCOMES, Rows, Summary, summarise
from jaxwalk.policies.host import DriverError, HostDriver
from jaxwalk.provenance import Provenance
from jaxwalk.scenarios import Source
from jaxwalk.sim.environment import Street

SCHEMA = 5
"""Version of the JSON document; it changes when reports need something new."""

HEADLINE = ("goal_rate", "collision_rate", "timeout_rate", "mean_time_to_goal", "mean_delay", "preventable_share")
"""Numbers of a cell that the document repeats at the top."""


@dataclass(frozen=True)
class Cell:
    """The results of one driver among one population."""

    driver: str
    """The driver's name."""
    pedestrians: str
    """The population's name."""
    driver_mode: str
    """``mode`` (takes the likeliest action) or ``sample``."""
    pedestrian_mode: str
    jaywalk_multiplier: float
    summary: Summary
    """The numbers of all metrics."""
    driver_observes: str
    """Name of the driver's observation set. No real car could have one of `jaxwalk.sim.observation.PRIVILEGED_SETS`."""
    pedestrian_observes: str
    driver_ms_per_step: float | None = None
    """Mean time that a driver outside JAX took for one step of its batch [ms]; None for a driver in JAX."""
    training_seed: int | None = None
    """Seed of the trained driver, or of the trained population, or of both; None if neither was trained."""
    counterfactuals: CounterfactualSummary | None = None
    """What would have avoided the collisions; None if they were not replayed."""
    by_map: tuple[MapRates, ...] = ()
    """How episodes ended on each map; empty if there is only one."""

    @property
    def goal_rate(self) -> Interval:
        """The share of episodes that reach the goal."""
        return Interval.of(self.summary[OUTCOMES].goal)

    @property
    def collision_rate(self) -> Interval:
        """The share of episodes that end in a collision."""
        return Interval.of(self.summary[OUTCOMES].collision)

    @property
    def timeout_rate(self) -> Interval:
        """The share of episodes that run out of time."""
        return Interval.of(self.summary[OUTCOMES].timeout)

    @property
    def mean_time_to_goal(self) -> Interval:
        """The mean time of episodes that reach the goal [s]."""
        return Interval.of(self.summary[OUTCOMES].time_to_goal)

    @property
    def mean_delay(self) -> Interval:
        """The mean delay of episodes that reach the goal [s]: beyond full throttle where there is nobody."""
        return Interval.of(self.summary[DELAY].mean)

    @property
    def preventable_share(self) -> Interval:
        """The share of the replayed collisions that a careful human would have avoided; None if none was replayed."""
        replayed = self.counterfactuals
        return Interval(None, None, None) if replayed is None else Interval.of(replayed.preventable)

    def headline(self) -> dict[str, dict[str, float | None]]:
        """Return the numbers of `HEADLINE`, each with its interval."""
        return {name: asdict(getattr(self, name)) for name in HEADLINE}

    def as_dict(self) -> dict[str, Any]:
        """Return plain dicts, lists and numbers: the headline first, then the whole summary."""
        cost = {} if self.driver_ms_per_step is None else {"driver_ms_per_step": self.driver_ms_per_step}
        replayed = {} if self.counterfactuals is None else {"counterfactuals": self.counterfactuals.as_dict()}
        by_map = {"by_map": [asdict(rates) for rates in self.by_map]} if self.by_map else {}
        return {
            "driver": self.driver,
            "pedestrians": self.pedestrians,
            "training_seed": self.training_seed,
            "driver_mode": self.driver_mode,
            "pedestrian_mode": self.pedestrian_mode,
            "driver_observes": self.driver_observes,
            "pedestrian_observes": self.pedestrian_observes,
            "jaywalk_multiplier": self.jaywalk_multiplier,
            **cost,
            **self.headline(),
            **by_map,
            **self.summary.as_dict(),
            **replayed,
        }


@dataclass(frozen=True)
class Results:
    """Drivers x populations on one set of scenarios, and the comparisons between them."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}
    """How pydantic reads a file: unknown fields and values of the wrong type are errors, here and in all parts."""

    scenarios: ScenarioSet
    cells: tuple[Cell, ...]
    compared: tuple[ComparedEnding, ...] = ()
    """Two drivers of an evaluation, compared."""
    shields: tuple[ShieldEffect, ...] = ()
    """What shields change, whose drivers were evaluated without them too."""
    over_seeds: tuple[SeedNumbers, ...] = ()
    """Numbers over training seeds, for each driver, population and jaywalk multiplier; in reports only."""
    paired: tuple[PairedSeeds, ...] = ()
    """Pairs of the same scenarios, over training seeds; in reports only."""
    every_two: tuple[PairedSeeds, ...] = ()
    """Hits of every two drivers among each population, for the verdict of a report."""
    paired_delays: tuple[PairedDelay, ...] = ()
    """The same of delays; in studies only."""
    street: StreetOrigin | None = None
    """Where it was; None in documents of older versions, and what follows is None or empty there."""
    drivers: tuple[PolicyOrigin, ...] = ()
    populations: tuple[PolicyOrigin, ...] = ()
    options: EvaluationOptions | None = None
    """What `jaxwalk evaluate` was asked for; None if another command made the results."""
    made: Provenance | None = None

    def cell(self, driver: str, pedestrians: str) -> Cell:
        """Return the cell of a driver and a population. Raise KeyError if there is none."""
        for cell in self.cells:
            if (cell.driver, cell.pedestrians) == (driver, pedestrians):
                return cell
        raise KeyError(f"no cell for {driver} among {pedestrians}")

    def as_dict(self) -> dict[str, Any]:
        """Return the document. But for rounding, only ``made`` and ``driver_ms_per_step`` depend on where or when.

        Empty parts are left out, and so is each cell's training seed if there are no numbers over seeds.
        """
        cells = [cell.as_dict() for cell in self.cells]
        if not self.over_seeds:
            cells = [{name: value for name, value in cell.items() if name != "training_seed"} for cell in cells]
        lists = ("drivers", "populations", "over_seeds", "paired", "every_two", "paired_delays", "compared", "shields")
        parts = {name: [asdict(one) for one in getattr(self, name)] for name in lists}
        return {
            "schema": SCHEMA,
            "scenarios": self.scenarios.as_dict(),
            **self._circumstances(),
            "cells": cells,
            **{name: part for name, part in parts.items() if part},
        }

    def _circumstances(self) -> dict[str, Any]:
        """Return what is known about where the results were made, and what was asked for."""
        known = {"street": self.street and self.street.as_dict()}
        known |= {name: (found := getattr(self, name)) and asdict(found) for name in ("options", "made")}
        return {name: found for name, found in known.items() if found}

    def to_json(self) -> str:
        """Return the document as text; the same results give the same text. Numbers that do not exist are null."""
        return json.dumps(self.as_dict(), indent=2, allow_nan=False) + "\n"


class Stopped(ValueError):
    """Raised if a policy fails in the middle of a grid. The message is that of the policy's error."""

    def __init__(self, message: str, rows: dict[tuple[str, str], Rows]) -> None:
        """Keep ``rows``, the rows evaluated until then, in whole batches."""
        super().__init__(message)
        self.rows = rows


def evaluate_grid(
    street: Street,
    drivers: Mapping[str, Policy],
    populations: Mapping[str, Policy],
    source: Source,
    *,
    batch: int | None = None,
    progress: Callable[[str, str, int, int], None] | None = None,
) -> tuple[Results, dict[tuple[str, str], Rows]]:
    """Evaluate every driver among every population, on the same scenarios. Return also the rows of each such pair.

    Args:
        street: the world.
        drivers: drivers by name.
        populations: pedestrian policies by name.
        source: the scenarios.
        batch: episodes played at once (default: as `evaluate`).
        progress: called with driver, population, episodes of the cell played so far, and the total.

    Raises:
        ValueError: ``batch`` is below 1.
        Stopped: a driver that is not JAX failed, or an action isn't in its space; the error holds the rows so far.
    """
    cells, rows = [], {}
    for driver_name, driver in drivers.items():
        for name, pedestrians in populations.items():
            tell = partial(progress, driver_name, name) if progress is not None else None
            policies = {"driver": driver, "pedestrian": pedestrians}
            batches = evaluate_batches(street, policies, source, batch=batch, progress=tell)
            before = driver_cost(driver)
            measured, failure = _joined(batches, {"driver": driver_name, "pedestrian": name})
            if measured is not None:
                rows[driver_name, name] = measured
            if measured is None or failure is not None:
                raise Stopped(str(failure), rows) from failure
            cost = ms_per_step(driver_cost(driver) - before)
            cells.append(make_cell(street, (driver_name, driver), (name, pedestrians), measured, cost))
    return Results(ScenarioSet.of(source), tuple(cells), street=StreetOrigin.of(street)), rows


def _joined(batches: Iterable[Rows], names: Roles[str]) -> tuple[Rows | None, DriverError | ActionError | None]:
    """Return the rows of all batches, or of those before a policy failed (None if none), and the policy's error."""
    parts, failure = [], None
    try:
        for part in batches:
            parts.append(part)
    except DriverError as error:
        failure = error
    except ActionError as error:
        failure = error.by(names)
    return Rows.join(parts) if parts else None, failure


def driver_cost(driver: Policy) -> Float[np.ndarray, "2"]:
    """Return the time that a driver took so far [s], and its steps; zeros for a compiled driver."""
    host = next((x for x in jax.tree.leaves(driver) if isinstance(x, HostDriver)), None)
    return np.array((0, 0) if host is None else (host.seconds_spent, host.steps_made), float)


def ms_per_step(cost: Float[np.ndarray, "2"]) -> float | None:
    """Return the mean time of a step [ms], from the time of all [s] and their number; None without steps."""
    seconds, steps = cost.tolist()
    return round(1000 * seconds / steps, 3) if steps else None


def make_cell(
    street: Street,
    driver: tuple[str, Policy],
    pedestrians: tuple[str, Policy],
    rows: Rows,
    driver_ms_per_step: float | None = None,
) -> Cell:
    """Return the cell of these rows, as `evaluate` returns them for these named policies on this street."""
    (driver_name, car), (population_name, people) = driver, pedestrians
    return Cell(
        driver=driver_name,
        pedestrians=population_name,
        driver_mode=acts_by(car),
        pedestrian_mode=acts_by(people),
        jaywalk_multiplier=jaywalk_multiplier(street),
        summary=summarise(rows),
        driver_observes=car.view.name,
        pedestrian_observes=people.view.name,
        driver_ms_per_step=driver_ms_per_step,
        by_map=rates_by_map(rows),
    )
