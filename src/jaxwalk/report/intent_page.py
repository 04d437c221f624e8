"""Write the document of `jaxwalk hidden-intent` as a Markdown page."""

from __future__ import annotations

from jaxwalk.report.intent_document import IntentDocument, IntentStreet, KnownIntent
from jaxwalk.report.material import ALWAYS_GO
from jaxwalk.report.seed_tables import paired_table
from jaxwalk.report.table import NONE, Table, shown
from jaxwalk.sim.observation import HIDDEN
from jaxwalk.wording import counted

BLIND = "blind"
"""Name of the car that the others are compared with."""
KNOWS = {
    BLIND: "sees where people are and how they move, as far as its car perceives them",
    "placebo": "is also told a number about each of the nearest people that decides nothing, so that it has as many "
    "inputs as `told`",
    "belief": "is also told the posterior mean of their jaywalking tendencies, given the crossings that it saw and, "
    "where people can be hidden, one decision of each of them from before",
    "told": "is also told the tendencies",
    "decided": "is also told who of them has decided to jaywalk, and where they will step out",
    "memory": "sees what `blind` sees, and who was last seen up to 3 s ago",
    "aware": "sees what `memory` sees, and which sides of its way are hidden",
    "x-ray": "sees what `blind` sees, but of everybody, hidden or not",
}
"""What each car knows, in words."""


def page(document: IntentDocument) -> str:
    """Return all tables, for each jaywalk multiplier."""
    plan, made = document.plan, document.provenance
    chosen, cells = document.streets[0].results.scenarios, document.streets[0].results.cells
    seeds = ", ".join(str(plan.seed + i) for i in range(plan.seeds))
    parts = [
        "# The cost of hidden intent",
        f"The same car, trained alone among {ALWAYS_GO} with the recipe `{plan.recipe}`. "
        + " ".join(f"`{name}` {KNOWS[name]}." for name in dict.fromkeys(cell.driver for cell in cells))
        + " What the critic sees is the same for all.",
        f"Training seeds: {seeds}; {counted(plan.updates, 'update')} each. {chosen.name}, hash {chosen.hash}; "
        f"commit {made.commit or 'unknown'}, "
        f"{made.hardware}. Brackets are 95 % intervals over training seeds and scenarios.",
    ]
    for street in document.streets:
        parts.append(f"## Jaywalk multiplier {street.jaywalk_multiplier:g}")
        parts += [table(street).markdown() for table in (_drivers, _pairs, _known)]
    return "\n\n".join(parts) + "\n"


def _drivers(street: IntentStreet) -> Table:
    observes = {cell.driver: cell.driver_observes for cell in street.results.cells}
    columns = (
        "driver",
        "observes",
        "goal %",
        "collision %",
        "of each seed",
        "timeout %",
        "time to goal [s]",
        "delay [s]",
    )
    rows = []
    for found in street.results.over_seeds:
        name = found.driver
        sees = f"`{observes[name]}`" + (" (no real car could)" if observes[name] in HIDDEN else "")
        rates = (found.goal_rate, found.collision_rate, found.timeout_rate)
        goal, collision, timeout = (shown(rate.mean, digits=2) for rate in rates)
        each = ", ".join(f"{100 * value:.2f}" for value in found.collision_rate.each if value is not None)
        time = shown(found.mean_time_to_goal.mean, 1.0, 2)
        delay = shown(found.mean_delay.mean, 1.0, 2)
        rows.append((name, sees, goal, collision, each, timeout, time, delay))
    return Table(columns, tuple(rows))


def _pairs(street: IntentStreet) -> Table:
    return paired_table(street.results.paired)


def _known(street: IntentStreet) -> Table:
    """Return the table of how much could be known (`jaxwalk.metrics.identifiability`)."""
    columns = (
        "seen", "people", "crossings of each", "never seen to cross %", "standard deviation of tau",
        "variance explained %", "information [bit]",
    )  # fmt: skip
    return Table(columns, tuple(_known_row(found) for found in street.identifiability))


def _known_row(found: KnownIntent) -> tuple[str, ...]:
    known = found.known
    if known is None:
        return (found.seen, "0", *[NONE] * 5)
    never, explained = (f"{100 * share:.1f}" for share in (known.never, known.explained))
    seen = (found.seen, f"{known.people:,}", f"{known.crossings:.2f}", never)
    return (*seen, f"{known.deviation:.3f}", explained, f"{known.bits:.3f}")
