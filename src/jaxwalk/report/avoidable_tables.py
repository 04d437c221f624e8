"""The tables of replayed collisions: who could have avoided them, and whether a careful human would have."""

from __future__ import annotations

from collections.abc import Iterator

from jaxwalk.evaluation.avoidable import Avoidable, CounterfactualSummary, Judged
from jaxwalk.report.driving_tables import Named
from jaxwalk.report.table import Table, shown
from jaxwalk.wording import counted

BY_WHOM = (
    "Collisions replayed with one thing changed. Avoidable by the driver: by braking fully, or by a planner that knows "
    "the future, from the moment the pedestrian entered the road; by the pedestrian: by waiting at the kerb, or by "
    "crossing on the crosswalk. For a person hit on a sidewalk, the driver acts from 3 s before the collision on "
    "(docs: metrics)."
)
JUDGED = (
    "The same collisions with another driver in the car's place, from the moment at which the car first perceived the "
    "person, and from the start. Preventable: a careful human (in the style of UN R157) would have avoided the "
    "collision. Only an oracle: the human would not, but a driver who knows the future, or one who brakes fully as "
    "soon as the person is seen, would have. Seen for: median time from that moment to the collision. Where nothing "
    "hides people, somebody is seen within the range of sight."
)


def by_whom(cells: Named) -> Table:
    """Return who could have avoided the collisions."""
    columns = (
        "driver", "contact", "replayed", "by either %", "only by the driver %", "only by the pedestrian %",
        "unavoidable %", "braking avoids %", "planner avoids %", "planner all the way avoids %",
    )  # fmt: skip
    rows = []
    for name, kind, count, part in _groups(cells):
        labels = (shown(part.labels[label]) for label in ("either", "driver", "pedestrian", "unavoidable"))
        avoided = (shown(part.avoided[change]) for change in ("brake", "planner", "planner_from_start"))
        rows.append((name, kind, count, *labels, *avoided))
    return Table(columns, tuple(rows))


def judged(cells: Named) -> Table:
    """Return which driver in the car's place would have avoided the collisions."""
    columns = (
        "driver", "contact", "replayed", "preventable %", "only by an oracle %", "unavoidable %", "seen for [s]",
        "from the start: preventable %", "from the start: only by an oracle %", "from the start: unavoidable %",
    )  # fmt: skip
    rows = [
        (name, kind, count, *_judgements(part.judged), shown(part.seen_for, 1.0), *_judgements(part.judged_from_start))
        for name, kind, count, part in _groups(cells)
    ]
    return Table(columns, tuple(rows))


def _judgements(found: Judged) -> tuple[str, ...]:
    return tuple(shown(rate) for rate in (found.human, found.oracle, found.unavoidable))


def _groups(cells: Named) -> Iterator[tuple[str, str, str, Avoidable]]:
    """Yield the name, the contact, the count and the numbers of each group of replayed collisions."""
    for name, cell in cells:
        if cell.counterfactuals is None:
            continue
        for kind, part in _replayed(cell.counterfactuals).items():
            of = f" of {cell.counterfactuals.collisions:,}" if kind == "all" else ""
            yield name, kind, f"{part.collisions:,}{of}", part


def _replayed(found: CounterfactualSummary) -> dict[str, Avoidable]:
    """Return the kinds of contact with replayed collisions; all of them together come first."""
    kinds = ("all", "moving", "crosswalk", "jaywalk", "sidewalk")
    return {kind: part for kind in kinds if (part := getattr(found, kind)).collisions}


def said(cells: Named) -> list[str]:
    """Return in words how many of each cell's replayed contacts a careful human would have avoided."""
    return [f"{name}: {_in_words(cell.counterfactuals)}" for name, cell in cells if cell.counterfactuals]


def _in_words(found: CounterfactualSummary) -> str:
    """Return the judgements of a cell in a sentence."""
    if not found.replayed:
        return "no contact was replayed"
    first, start = found.all.judged, found.all.judged_from_start
    return (
        f"a careful human would have avoided {first.human.successes:,} of {counted(found.replayed, 'contact')} "
        f"({shown(first.human)} %) from when the person was first seen, only an oracle {first.oracle.successes:,}, "
        f"neither {first.unavoidable.successes:,}; from the start {start.human.successes:,}, "
        f"{start.oracle.successes:,} and {start.unavoidable.successes:,}"
    )
