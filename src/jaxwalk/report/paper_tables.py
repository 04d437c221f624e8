"""The tables of the report: ours with 95 % intervals next to the paper's numbers, and a sentence where they differ."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import product

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.results import Cell
from jaxwalk.metrics import ATTRIBUTION, ENCOUNTERS, JAYWALK_RATE, OUTCOMES, SPEED_DIFFERENTIAL, WAITING, OverSeeds
from jaxwalk.report import avoidable_tables, driving_tables, published, surprise, verdicts
from jaxwalk.report.figures.people import SHARES
from jaxwalk.report.material import ALWAYS_GO, CO_TRAINED, LEARNED, SINGLE_AGENT, Material
from jaxwalk.report.seed_tables import pairs, training_seeds
from jaxwalk.report.table import MOVING, NONE, Table, by_type, shown
from jaxwalk.report.verdicts import Versus, brief, verdict

QUARTER_NAMES = ("0 to 0.25", "0.25 to 0.5", "0.5 to 0.75", "0.75 to 1")


def make_all(names: Iterable[str], material: Material) -> dict[str, Table]:
    """Return the tables with these names; a column of the paper's numbers is left out where it has none."""
    return {name: _with_theirs(TABLES[name](material), material.beside_paper) for name in names}


def _with_theirs(table: Table, beside: bool) -> Table:
    """Return the table without columns of the paper's numbers that have none, or where they can't stand beside ours."""
    known = [beside and any(row[place] != NONE for row in table.rows) for place in range(len(table.columns))]
    kept = [place for place, column in enumerate(table.columns) if known[place] or not _is_theirs(column)]
    columns, *rows = (tuple(row[place] for place in kept) for row in (table.columns, *table.rows))
    return replace(table, columns=columns, rows=tuple(rows))


def _is_theirs(column: str) -> bool:
    return "paper" in (column.partition(", ")[0], column.rpartition(", ")[2])


def _beside(material: Material, against: list[Versus], reason: str) -> dict[str, str]:
    """Return where ours differ from the paper's, if the experiment is the paper's: the reasons concern its drivers."""
    if material.trainings is None:
        return {}
    return {"verdict": verdict(against, reason), "brief": brief(against)}


def matrix(material: Material) -> Table:
    """Return the table of every driver among every population."""
    rates = ("goal", "collision", "timeout")
    percents = (column for rate in rates for column in _columns(material, rate))
    columns = ("driver", "pedestrians", *percents, MOVING, "collisions per km", "time to goal [s]", "delay [s]")
    rows = []
    for name, people in ((name, people) for name in material.drivers for people in material.populations):
        found = material.over_seeds(name, people)
        ended = (found.goal_rate, found.collision_rate, found.timeout_rate)
        percents = (text for rate in ended for text in _shown(material, rate))
        moving, per_km = shown(found.moving_contact_rate.mean), shown(found.collisions_per_km.mean, 1.0, 2)
        times = (shown(found.mean_time_to_goal.mean, 1.0), shown(found.mean_delay.mean, 1.0, 2))
        rows.append((name, people, *percents, moving, per_km, *times))
    return Table(columns, tuple(rows))


def _columns(material: Material, rate: str) -> tuple[str, ...]:
    """Return a rate's column names: its mean over training seeds and, of several, the interquartile mean."""
    return (f"{rate} %", f"{rate} %, IQM") if material.several else (f"{rate} %",)


def _shown(material: Material, number: OverSeeds) -> tuple[str, ...]:
    """Return the cells of these columns."""
    mean = shown(number.mean)
    return (mean, shown(Interval(number.iqm, None, None))) if material.several else (mean,)


def baselines(material: Material) -> Table:
    """Return the paper's figure of baselines: for each method, ours among each population, and theirs."""
    columns = (
        "driver",
        *(f"{rate} %, {who}" for rate in ("goal", "collision") for who in (*material.populations, "paper")),
    )
    theirs = dict(published.BASELINES)
    theirs[SINGLE_AGENT] = published.TRAINED[SINGLE_AGENT, ALWAYS_GO]
    theirs[CO_TRAINED] = published.TRAINED[CO_TRAINED, LEARNED]
    rows, against = [], []
    for name in material.drivers:
        row = [name]
        found = {people: material.over_seeds(name, people) for people in material.populations}
        goals = {people: numbers.goal_rate.mean for people, numbers in found.items()}
        collisions = {people: numbers.collision_rate.mean for people, numbers in found.items()}
        for place, ours in enumerate((goals, collisions)):
            row += [shown(x) for x in ours.values()]
            row.append(f"{theirs[name][place]:g}" if name in theirs else NONE)
            if name in published.BASELINES:
                what = f"{('goals', 'collisions')[place]} of {name} among {material.crowd}"
                against.append(Versus(what, ours[material.crowd], theirs[name][place]))
        rows.append(tuple(row))
    return Table(columns, tuple(rows), **_beside(material, against, verdicts.BASELINES))


def co_training(material: Material) -> Table:
    """Return the paper's two by two: single-agent and co-trained driver, among always-go and learned pedestrians."""
    goals, collisions = (_columns(material, rate) for rate in ("goal", "collision"))
    columns = ("driver", "pedestrians", *goals, "paper", *collisions, "paper")
    rows, against = [], []
    for (driver, people), (goal, collision) in published.TRAINED.items():
        found = material.over_seeds(driver, people)
        goals, collisions = (_shown(material, rate) for rate in (found.goal_rate, found.collision_rate))
        rows.append((driver, people, *goals, f"{goal:g}", *collisions, f"{collision:g}"))
        against.append(Versus(f"goals of {driver} among {people}", found.goal_rate.mean, goal))
        against.append(Versus(f"collisions of {driver} among {people}", found.collision_rate.mean, collision))
    return Table(columns, tuple(rows), **_beside(material, against, verdicts.TRAINED))


def speed_differential(material: Material) -> Table:
    """Return car speed near jaywalkers minus near crosswalk users by distance, four ways, and a conclusion."""
    bins = material.cell(material.subject, material.crowd).summary[SPEED_DIFFERENTIAL]
    low, high = published.SPEED_GAP_FARTHER
    rows = []
    for place, weight, *numbers in surprise.four_ways(bins):
        nearest = place == surprise.place(bins[0])
        theirs = f"{published.SPEED_GAP}" if nearest else f"{low:.2f} to {high:.2f}"
        rows.append((place, weight, *numbers, theirs if weight == "frames" else NONE))
    gap = Versus("difference within 3 m, pooled", bins[0].pooled.difference, published.SPEED_GAP, "m/s", 1.0)
    beside = _beside(material, [gap], verdicts.SPEED)
    beside["verdict"] = f"{surprise.in_words(bins)} {beside.get('verdict', '')}".strip()
    return Table((*surprise.COLUMNS, "paper"), tuple(rows), **beside)


def attribution(material: Material) -> Table:
    """Return jaywalking's share of collisions next to its share of crossings and exposure, and the ratio of rates."""
    columns = ("jaywalking's share", *(f"among {people}, %" for people in material.populations), "paper, %")
    found = {people: material.cell(material.subject, people).summary[ATTRIBUTION] for people in material.populations}
    theirs = (f"{published.COLLISIONS_JAYWALK:g}", f"{published.CROSSINGS_JAYWALK:g}", NONE, NONE, NONE)
    rows = [
        (name, *(shown(find(found[people])) for people in material.populations), value)
        for (name, find), value in zip(SHARES.items(), theirs, strict=True)
    ]
    risks = {
        "crossing": [found[people].per_crossing for people in material.populations],
        "second on a roadway": [found[people].per_second for people in material.populations],
    }
    for name, of_populations in risks.items():
        ratios = (shown(risk.ratio, 1.0) for risk in of_populations)
        rows.append((f"collisions per {name}: jaywalk / crosswalk (a ratio, not %)", *ratios, NONE))
    mine = found[material.crowd]
    against = [
        Versus("share of collisions", mine.share, published.COLLISIONS_JAYWALK),
        Versus("share of crossings", mine.per_crossing.share, published.CROSSINGS_JAYWALK),
    ]
    return Table(columns, tuple(rows), **_beside(material, against, verdicts.ATTRIBUTION))


def contacts(material: Material) -> Table:
    """Return what people in the subject's collisions were doing, and whether the car was moving."""
    columns = (
        "pedestrians",
        "contact",
        "collisions",
        "share %",
        "car moving",
        "car standing",
        "mean impact speed [m/s]",
    )
    rows = []
    for people in material.populations:
        outcomes = material.cell(material.subject, people).summary[OUTCOMES]
        contacts = {"crosswalk": outcomes.crosswalk, "jaywalk": outcomes.jaywalk, "sidewalk": outcomes.sidewalk}
        for kind, c in contacts.items():
            counts = (str(c.moving + c.standing), shown(c.share), str(c.moving), str(c.standing))
            rows.append((people, kind, *counts, shown(c.impact_speed, 1.0)))
    return Table(columns, tuple(rows))


def quarters(material: Material) -> Table:
    """Return the jaywalk rate by quarter of the trait."""
    cell = material.cell(material.subject, material.crowd)
    found, most = cell.summary[JAYWALK_RATE], 100 * cell.jaywalk_multiplier
    expected = [most * (0.125 + 0.25 * i) for i in range(4)]
    against = [
        Versus(name, ours, x) for name, ours, x in zip(QUARTER_NAMES, found.quarters, published.QUARTERS, strict=True)
    ]
    rows = [
        (name, shown(ours), f"{mean:.1f}", f"{theirs}", f"{ours.trials:,}")
        for name, ours, mean, theirs in zip(QUARTER_NAMES, found.quarters, expected, published.QUARTERS, strict=True)
    ]
    rows.append(
        (
            "all",
            shown(found.all),
            f"{most / 2:.1f}",
            f"{published.CROSSINGS_JAYWALK:g}",
            f"{found.all.trials:,}",
        )
    )
    columns = ("jaywalking tendency", "jaywalk %", "by equation 1", "paper", "decisions")
    return Table(columns, tuple(rows), **_beside(material, against, verdicts.QUARTERS))


def waiting(material: Material) -> Table:
    """Return whether learned pedestrians wait at the kerb, before which driver, and at what cost."""
    rates = ("waits in danger %", "moments", "else near %", "harmless %", "moments")
    price = ("waits of all steps %", "pace [m/s]", "of always-go's %", "longest stand on a roadway [steps]")
    rows = []
    for driver in material.drivers:
        found, bold = (material.cell(driver, people).summary[WAITING] for people in (material.crowd, ALWAYS_GO))
        danger, harmless, pace, most = found.danger, found.harmless, found.pace, bold.pace.value
        row = (driver, shown(danger), f"{danger.count:,}", shown(found.other), shown(harmless), f"{harmless.count:,}")
        share = f"{100 * pace.value / most:.1f}" if most and pace.value is not None else NONE
        rows.append((*row, shown(found.waited, digits=2), shown(pace, 1.0, 2), share, str(found.longest_stand)))
    return Table(("driver", *rates, *price), tuple(rows))


def approach(material: Material) -> Table:
    """Return the 5th percentile of the smallest distance in an encounter."""
    columns = ("encounter", "pedestrians", "5th percentile of the minimum approach [m]", "paper", "encounters")
    rows, against = [], []
    for people in material.populations:
        found = by_type(material.cell(material.subject, people).summary[ENCOUNTERS])
        for kind, theirs in published.APPROACH.items():
            ours = found[kind].minimum_approach
            rows.append((kind, people, shown(ours, 1.0, 2), f"{theirs}", f"{found[kind].count:,}"))
            if people == material.crowd:
                against.append(Versus(kind, ours, theirs, "m", 1.0))
    return Table(columns, tuple(rows), **_beside(material, against, verdicts.APPROACH))


def braking(material: Material) -> Table:
    """Return the time from road entry to the car's braking."""
    times = ("median of all [s]", "mean of those who brake [s]", "paper")
    columns = ("encounter", "pedestrians", *times, "brake", "never", "already", "standing")
    rows = []
    for people in material.populations:
        met = material.cell(material.subject, people).summary[ENCOUNTERS]
        for kind, found in (("jaywalk", met.jaywalk.braking), ("crosswalk", met.crosswalk.braking)):
            theirs = f"{published.BRAKING}" if kind == "jaywalk" else NONE
            counts = (f"{count:,}" for count in (found.observed, found.censored, found.already, found.standing))
            rows.append(
                (kind, people, shown(found.median, 1.0, 2), shown(found.mean_observed, 1.0, 2), theirs, *counts)
            )
    ours = material.cell(material.subject, material.crowd).summary[ENCOUNTERS].jaywalk.braking.mean_observed
    against = [Versus("mean time to braking for jaywalkers", ours, published.BRAKING, "s", 1.0)]
    return Table(columns, tuple(rows), **_beside(material, against, verdicts.BRAKING))


def ablation(material: Material) -> Table:
    """Return the results of the co-trained driver with less and more jaywalking."""
    columns = (
        "multiplier",
        "jaywalk % of crossings",
        "paper",
        "pedestrians",
        "goal %",
        "paper",
        "collision %",
        "paper",
    )
    rows, against = [], []
    for multiplier in material.multipliers:
        for people in material.ablated_populations:
            found = material.ablated(multiplier, people)
            share = shown(found.jaywalk_share.mean)
            pair = published.ABLATION.get(multiplier) if people == ALWAYS_GO else None
            theirs = [NONE, NONE] if pair is None else [f"{x:g}" for x in pair]
            goal, collision = found.goal_rate.mean, found.collision_rate.mean
            said = f"{published.JAYWALK_SHARE[multiplier]:g}" if multiplier in published.JAYWALK_SHARE else NONE
            rows.append((f"{multiplier:g}", share, said, people, shown(goal), theirs[0], shown(collision), theirs[1]))
            if pair:
                against.append(Versus(f"goals at multiplier {multiplier:g}", goal, pair[0]))
                against.append(Versus(f"collisions at multiplier {multiplier:g}", collision, pair[1]))
    return Table(columns, tuple(rows), **_beside(material, against, verdicts.ABLATION))


def _first_seed(material: Material) -> list[tuple[str, Cell]]:
    """Return every driver among every population, with its name in a table; of trainings the first seed."""
    pairs = product(material.drivers, material.populations)
    return [(f"{driver} among {people}", material.cell(driver, people)) for driver, people in pairs]


TABLES: dict[str, Callable[[Material], Table]] = {
    "baselines": baselines,
    "co_training": co_training,
    "matrix": matrix,
    "training_seeds": training_seeds,
    "pairs": pairs,
    "speed_differential": speed_differential,
    "attribution": attribution,
    "contacts": contacts,
    "quarters": quarters,
    "waiting": waiting,
    "kerb": lambda material: driving_tables.kerb(_first_seed(material)),
    "driving": lambda material: driving_tables.driving(_first_seed(material)),
    "preventable": lambda material: avoidable_tables.judged(_first_seed(material)),
    "approach": approach,
    "braking": braking,
    "ablation": ablation,
}
"""Every table, by the name of its file."""
