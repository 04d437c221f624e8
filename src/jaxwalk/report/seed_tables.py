"""The tables of each training seed, and of pairs of the same scenarios."""

from __future__ import annotations

from collections.abc import Sequence

from jaxwalk.evaluation.document_parts import Interval, PairedDelay, PairedSeeds
from jaxwalk.evaluation.harm_numbers import Harm, PairedHarm
from jaxwalk.metrics import ATTRIBUTION, DELAY, SPEED_DIFFERENTIAL, holm
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.material import CO_TRAINED, SINGLE_AGENT, Material
from jaxwalk.report.table import MOVING, Table, p_value, shown

HARM_NAMES: dict[Harm, str] = {
    "worst hundredth": "worst hundredth [m/s]",
    "serious injuries": "serious injuries in 1,000",
}
"""How tables call the numbers of harm."""


def training_seeds(material: Material) -> Table:
    """Return the trained drivers of each training seed, with intervals over scenarios."""
    columns = (
        "driver", "pedestrians", "training seed", "goal %", "collision %", MOVING, "delay [s]",
        "speed difference within 3 m [m/s]", "jaywalking's share of collisions %",
    )  # fmt: skip
    rows = []
    for driver, people in (
        (driver, people) for driver in (SINGLE_AGENT, CO_TRAINED) for people in material.populations
    ):
        for seed in material.training_seeds:
            cell = material.cell_of_seed(driver, people, seed)
            rates = (shown(cell.goal_rate), shown(cell.collision_rate))
            gap = shown(cell.summary[SPEED_DIFFERENTIAL][0].pooled.difference, 1.0, 2)
            moving = shown(cell.summary[MEASURED_CONTACTS].footprint.moving)
            share, delay = shown(cell.summary[ATTRIBUTION].share), shown(cell.summary[DELAY].mean, 1.0, 2)
            rows.append((driver, people, str(seed), *rates, moving, delay, gap, share))
    return Table(columns, tuple(rows))


def pairs(material: Material) -> Table:
    """Return how the same scenarios end: for each driver by population, and for the two trained drivers."""
    return paired_table(material.results.paired)


def paired_table(paired: Sequence[PairedSeeds]) -> Table:
    """Return a row for each result of `jaxwalk.evaluation.paired_over_seeds`; Holm's p covers all tests."""
    columns = ("of", "A", "B", "A %", "B %", "B minus A, points", "A alone", "B alone", "p", "p, Holm")
    adjusted = iter(holm([found.p for found in paired if found.p is not None]))
    rows = ((*_pair(found), p_value(None if found.p is None else next(adjusted))) for found in paired)
    return Table(columns, tuple(rows))


def delay_table(paired: Sequence[PairedDelay]) -> Table:
    """Return a row for each result of `jaxwalk.evaluation.paired_delay`; Holm's p covers all tests."""
    columns = ("of", "A", "B", "people", "B minus A [s]", "p", "p, Holm")
    adjusted = iter(holm([found.p for found in paired if found.p is not None]))
    rows = []
    for found in paired:
        tested = p_value(found.p), p_value(None if found.p is None else next(adjusted))
        rows.append(("delay", found.a, found.b, found.pedestrians, shown(found.difference, 1.0, 2), *tested))
    return Table(columns, tuple(rows))


def harm_table(paired: Sequence[PairedHarm]) -> Table:
    """Return a row for each result of `jaxwalk.evaluation.harm_numbers.paired_harm`; Holm's p covers all tests."""
    columns = ("of", "A", "B", "B minus A", "p", "p, Holm")
    adjusted = iter(holm([one.p for one in paired if one.p is not None]))
    rows = []
    for one in paired:
        tested = p_value(one.p), p_value(None if one.p is None else next(adjusted))
        rows.append((HARM_NAMES[one.harm], one.a, one.b, shown(one.difference, 1.0, 2), *tested))
    return Table(columns, tuple(rows))


def _pair(found: PairedSeeds) -> tuple[str, ...]:
    names = (f"{side.driver} among {side.pedestrians}" for side in (found.a, found.b))
    rates = (shown(Interval(side.rate, None, None)) for side in (found.a, found.b))
    counts = (f"{found.only_a:,}", f"{found.only_b:,}")
    return f"{found.ending}s", *names, *rates, shown(found.difference), *counts, p_value(found.p)
