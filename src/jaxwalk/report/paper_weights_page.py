"""Write the results of `jaxwalk co-training --sweep` as a Markdown page."""

from __future__ import annotations

from jaxwalk.evaluation.results import Results
from jaxwalk.metrics import APPROACHES, SPEED_DIFFERENTIAL
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.material import ALWAYS_GO
from jaxwalk.report.table import MOVING, NONE, Table, shown
from jaxwalk.wording import counted

ABOUT = (
    "The paper names the car's caution near people, its progress and a bonus for waiting, without weights or places. "
    "`as-it-is` is recipe `paper`; in every other training one of them is changed: the caution times 5 or 10, the "
    "progress times 2, the bonus paid wherever somebody waits before a near, fast car, not at the kerb alone. "
    "`learned` are the people who learned beside the car."
)
TABLE = (
    "Touched: episodes in which the moving car touched somebody by its footprint, which is what a collision is here. "
    "People wait: approaches to the kerb with a dangerous moment in which the person waits through the first one; who "
    "has learned nothing waits in half of them. Faster near jaywalkers: the car's mean speed within 3 m of a jaywalker "
    "minus that within 3 m of a crosswalk user (the paper: 2.65 m/s)."
)


def page(results: Results, *, updates: int, planned: int) -> str:
    """Return the table, and how little may be read from it; ``updates`` of the ``planned`` ones were made."""
    chosen, made = results.scenarios, results.made
    seeds = sorted({cell.training_seed for cell in results.cells if cell.training_seed is not None})
    origin = "" if made is None else f"; commit {made.commit or 'unknown'}, {made.hardware}"
    table = _table(results)
    parts = [
        "# The weights that the paper leaves open",
        f"**Exploratory**: {counted(len(seeds), 'training seed')} ({', '.join(map(str, seeds))}) and {updates:,} of "
        f"{planned:,} updates. Intervals are over scenarios and say nothing about training again, so no row may be "
        "called better than another; what differs widely is worth a study.",
        ABOUT,
        f"{chosen.name}, hash {chosen.hash}{origin}.",
        TABLE,
        table.markdown(),
    ]
    return "\n\n".join(parts) + "\n"


def _table(results: Results) -> Table:
    columns = (
        "weights", "people", "seed", MOVING, "goal %", "delay [s]", "people wait %",
        "faster near jaywalkers [m/s]",
    )  # fmt: skip
    rows = []
    for cell in results.cells:
        summary = cell.summary
        touched, goal = shown(summary[MEASURED_CONTACTS].footprint.moving), shown(cell.goal_rate)
        waits = NONE if cell.pedestrians == ALWAYS_GO else shown(summary[APPROACHES].waited)
        faster = shown(summary[SPEED_DIFFERENTIAL][0].pooled.difference, 1.0, 2)
        where = (cell.driver, cell.pedestrians, str(cell.training_seed))
        rows.append((*where, touched, goal, shown(cell.mean_delay, 1.0, 2), waits, faster))
    return Table(columns, tuple(rows))
