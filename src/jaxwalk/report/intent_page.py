"""The document of `jaxwalk hidden-intent` as a page of Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jaxwalk.report.material import ALWAYS_GO
from jaxwalk.report.seed_tables import paired_table
from jaxwalk.report.table import NONE, Table, markdown_table, shown
from jaxwalk.sim.observation import HIDDEN

BLIND = "blind"
"""Name of the car that the others are compared with."""


def page(document: Mapping[str, Any]) -> str:
    """All tables, for each jaywalk multiplier."""
    plan, made, streets = document.plan, document.provenance, document.streets
    chosen = streets[0].scenarios
    seeds = ", ".join(str(plan.seed + i) for i in range(plan.seeds))
    parts = [
        "# The cost of hidden intent",
        f"The same car, trained alone among {ALWAYS_GO}: `blind` sees where people are and how they move; `belief` is "
        "also told the posterior mean of the nearest people's jaywalking tendencies, given their crossings so far; "
        "`told` is told the tendencies. The critic sees the tendencies in all three cases.",
        f"Training seeds: {seeds}; {plan['updates']:,} updates each. {chosen['count']:,} "
        f"scenarios of seed {chosen['seed']}, hash {chosen['hash']}; commit {made['commit'] or 'unknown'}, "
        f"{made['hardware']}. Brackets are 95 % intervals over training seeds and scenarios.",
    ]
    for street in streets:
        parts.append(f"## Jaywalk multiplier {street['jaywalk_multiplier']:g}")
        parts += [_markdown(table(street)) for table in (_drivers, _pairs, _known)]
    return "\n\n".join(parts) + "\n"


def _markdown(table: Table) -> str:
    return markdown_table(table.columns, table.rows)


def _drivers(street: Mapping[str, Any]) -> Table:
    observes = {cell.driver: cell.driver_observes for cell in street.cells}
    columns = ("driver", "observes", "goal %", "collision %", "of each seed", "timeout %", "time to goal [s]")
    rows = []
    for found in street.over_seeds:
        name = found.driver
        sees = f"`{observes[name]}`" + (" (no real car could)" if observes[name] in HIDDEN else "")
        goal, collision, timeout = (
            shown(found[rate].mean, digits=2) for rate in ("goal_rate", "collision_rate", "timeout_rate")
        )
        each = ", ".join(f"{100 * value:.2f}" for value in found.collision_rate.each)
        time = shown(found.mean_time_to_goal.mean, 1.0, 2)
        rows.append((name, sees, goal, collision, each, timeout, time))
    return Table(columns, tuple(rows))


def _pairs(street: Mapping[str, Any]) -> Table:
    return paired_table(street.paired)


def _known(street: Mapping[str, Any]) -> Table:
    """How much could be known (`jaxwalk.metrics.identifiability`)."""
    columns = (
        "seen", "people", "crossings of each", "never seen to cross %", "standard deviation of tau (before: 0.289)",
        "variance explained %", "information [bit]",
    )  # fmt: skip
    return Table(columns, tuple(_known_row(found) for found in street.identifiability))


def _known_row(found: Mapping[str, Any]) -> tuple[str, ...]:
    seen, people = found.seen, f"{found['people']:,}"
    if not found.people:
        return (seen, people, *[NONE] * 5)
    percents = [f"{100 * found[name]:.1f}" for name in ("never", "explained")]
    rest = (f"{found['deviation']:.3f}", percents[1], f"{found['bits']:.3f}")
    return (seen, people, f"{found['crossings']:.2f}", percents[0], *rest)
