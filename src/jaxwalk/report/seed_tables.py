"""The tables of each training seed, and of pairs of the same scenarios."""

from __future__ import annotations

from collections.abc import Sequence

from jaxwalk.evaluation.document_parts import Interval, PairedDelay, PairedSeeds
from jaxwalk.evaluation.harm_numbers import Harm, PairedHarm
from jaxwalk.metrics import ATTRIBUTION, DELAY, SPEED_DIFFERENTIAL
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.material import CO_TRAINED, SINGLE_AGENT, Material
from jaxwalk.report.table import MOVING, Table, adjusted, p_value, shown

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
    of_all = adjusted([found.p for found in paired])
    return Table(columns, tuple((*_pair(found), p_value(p)) for found, p in zip(paired, of_all, strict=True)))


def delay_table(paired: Sequence[PairedDelay]) -> Table:
    """Return a row for each result of `jaxwalk.evaluation.paired_delay`; Holm's p covers all tests."""
    columns = ("of", "A", "B", "people", "B minus A [s]", "p", "p, Holm")
    rows = []
    for found, p in zip(paired, adjusted([found.p for found in paired]), strict=True):
        difference = shown(found.difference, 1.0, 2)
        rows.append(("delay", found.a, found.b, found.pedestrians, difference, p_value(found.p), p_value(p)))
    return Table(columns, tuple(rows))


def harm_table(paired: Sequence[PairedHarm]) -> Table:
    """Return a row for each result of `jaxwalk.evaluation.harm_numbers.paired_harm`; Holm's p covers all tests."""
    columns = ("of", "A", "B", "B minus A", "p", "p, Holm")
    rows = []
    for one, p in zip(paired, adjusted([one.p for one in paired]), strict=True):
        difference = shown(one.difference, 1.0, 2)
        rows.append((HARM_NAMES[one.harm], one.a, one.b, difference, p_value(one.p), p_value(p)))
    return Table(columns, tuple(rows))


def _pair(found: PairedSeeds) -> tuple[str, ...]:
    names = (f"{side.driver} among {side.pedestrians}" for side in (found.a, found.b))
    rates = (shown(Interval(side.rate, None, None)) for side in (found.a, found.b))
    counts = (f"{found.only_a:,}", f"{found.only_b:,}")
    return f"{found.ending}s", *names, *rates, shown(found.difference), *counts, p_value(found.p)
