"""Write the whole suite of an evaluation as one Markdown page: what a safety engineer would ask about every driver."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from jaxwalk.evaluation.results import Cell, Results
from jaxwalk.metrics import (
    ATTRIBUTION,
    ENCOUNTERS,
    IMPACT_TAIL,
    NEAR_MISSES,
    OUTCOMES,
    SPEED_DIFFERENTIAL,
    SURROGATES,
    scenarios_needed,
)
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.provenance import Provenance
from jaxwalk.report import avoidable_tables, driving_tables, surprise
from jaxwalk.report.table import NONE, Table, by_type, shown

TOLD_APART = ((0.14, 0.16), (0.021, 0.034), (0.01, 0.02), (0.004, 0.005), (0.001, 0.002))
"""Pairs of collision rates for the table of scenarios needed; the first are the paper's."""


def suite(results: Results, made: Provenance) -> str:
    """Return the page of an evaluation's results."""
    cells, chosen = results.cells, results.scenarios
    about = (
        f"{chosen.name} for every driver and population, hash "
        f"{chosen.hash}. Brackets: 95 % intervals. What each number is, and how its interval is made: the page on "
        "metrics. A dash: too few cases, or none."
    )
    versions = ", ".join(f"{name} {version}" for name, version in made.versions.items())
    origin = f"Made at commit {made.commit or 'unknown'} on {made.hardware}, {versions}."
    parts = ["# The suite", about, origin, *_named(results)]
    if results.compared:
        parts += ["## Compared", "\n".join(f"- {line}" for line in said(results))]
    if results.shields:
        parts += ["## Shields", "\n".join(f"- {line}" for line in shields_said(results))]
    if any(cell.counterfactuals for cell in cells):
        parts += ["## Preventable", "\n".join(f"- {line}" for line in preventable_said(results))]
    for heading, text, table in _sections(cells):
        parts += [f"## {heading}", text, table.markdown()]
    words = (f"- **{_name(cell)}**: {surprise.in_words(cell.summary[SPEED_DIFFERENTIAL])}" for cell in cells)
    return "\n\n".join(part for part in (*parts, "## In words", WORDS, "\n".join(words)) if part) + "\n"


def _named(results: Results) -> list[str]:
    """Return where it was and with what, as far as the results know it."""
    where = [f"Where: {results.street.in_words()}."] if results.street else []
    each = {"Drivers": results.drivers, "Populations": results.populations}
    return where + [f"{what}: {', '.join(x.in_words() for x in found)}." for what, found in each.items() if found]


def said(results: Results) -> list[str]:
    """Return the comparisons of two drivers in words, if there are any."""
    found = results.compared
    several = len({one.jaywalk_multiplier for one in found}) > 1
    lines = [f"Multiplier {one.jaywalk_multiplier:g}: " * several + one.in_words for one in found]
    return [*lines, "(Pairs of the same scenarios; exact tests, p adjusted for their number.)"] if found else []


def shields_said(results: Results) -> list[str]:
    """Return in words what shields change, if any does and its driver was evaluated without it too."""
    found = results.shields
    several = len({one.jaywalk_multiplier for one in found}) > 1
    return [f"Multiplier {one.jaywalk_multiplier:g}: " * several + one.in_words for one in found]


def preventable_said(results: Results) -> list[str]:
    """Return in words how many of each cell's replayed contacts a careful human would have avoided."""
    return avoidable_tables.said((_name(cell), cell) for cell in results.cells)


def _sections(cells: Sequence[Cell]) -> Iterable[tuple[str, str, Table]]:
    yield "Outcomes", "", outcomes(cells)
    if any(cell.by_map for cell in cells):
        yield "On each map", "", on_each_map(cells)
    named = [(_name(cell), cell) for cell in cells]
    yield "At the kerb", driving_tables.KERB, driving_tables.kerb(named)
    yield "How it drives", driving_tables.DRIVING, driving_tables.driving(named)
    yield "Contacts", CONTACTS_CAPTION, contacts(cells)
    yield "Encounters", ENCOUNTERS_CAPTION, surrogates(cells)
    yield "Contacts foretold by near misses", NEAR_MISS_CAPTION, near_misses(cells)
    yield "Whose collisions", ATTRIBUTION_CAPTION, attribution(cells)
    if any(cell.counterfactuals for cell in cells):
        yield "Could it have been avoided?", avoidable_tables.BY_WHOM, avoidable_tables.by_whom(named)
        yield "Would a careful human have avoided it?", avoidable_tables.JUDGED, avoidable_tables.judged(named)
    yield "How soon the car brakes", BRAKING, braking(cells)
    yield "Speed near jaywalkers and near crosswalk users", SPEEDS, speeds(cells)
    yield "How many scenarios it takes", POWER, power()


CONTACTS_CAPTION = (
    "Episodes with a contact, by the paper's rule (disc: centres closer than 1.5 m) and by the car's "
    "footprint (a body overlaps the car's rectangle), whichever of them ended the episodes. Standing: somebody walked "
    "into a car below 0.5 m/s. Front, side, rear: the part of the moving car that was touched first. Worst hundredth: "
    "the car's speed in the contacts that end episodes, 0 in an episode without one, on average over the hundredth of "
    "the episodes in which it is highest; under both rules it is the contact by the world's rule."
)
ENCOUNTERS_CAPTION = (
    "Shares of encounters with a time to collision below 1.5 s, a post-encroachment time below 1.5 s or a required "
    "deceleration above 3.4 m/s²; the smallest distance; and of those who were hit by a moving car, the mean speed and "
    "the risk of a serious injury or death (Monfort and Mueller, 2025), whose interval is over those who were hit: how "
    "sure the curve itself is, it leaves out."
)
NEAR_MISS_CAPTION = (
    "Episodes in which the moving car touches somebody on a roadway: as observed, and as near misses alone foretell. "
    "Of the smallest gap of each episode, those below the threshold have a tail (generalised Pareto) that is "
    "extrapolated to a contact. It cannot be extrapolated where the fit is poor, where a lower threshold finds "
    "something else, or where nothing bounds it; and where the two intervals have nothing in common, the extrapolation "
    "is wrong."
)
ATTRIBUTION_CAPTION = (
    "Collisions with people on a roadway: jaywalking's share of them, beside its share of the crossings; and how many "
    "times more collisions there are for each jaywalk than for each crossing on a crosswalk, and for each second on "
    "the road. 1: no more dangerous."
)
BRAKING = (
    "From a pedestrian's road entry to the car's braking onset: Kaplan-Meier median, which counts those who never "
    "brake while the pedestrian is on the road. A dash: fewer than half brake, or nobody was met."
)
SPEEDS = (
    "Mean speed of the car near jaywalkers minus that near crosswalk users [m/s], by the distance to the nearest of "
    "each on a roadway. Frames: every frame weighs alike, as in the paper's equation 2. Encounters: every encounter "
    "does. Matched: only cars at nearly the same place, headed the same way and as fast at first are compared. Ghosts: "
    "people that the car cannot see. People minus ghosts: among always-go, 0 for a car that does not see people; for "
    "one that does, ghosts share the places where it brakes for people, so the rest is the least that its reaction can "
    "be. Among learned pedestrians, some of it is their waiting."
)
WORDS = (
    "What the four say together, by 95 % intervals, each for itself. Beyond ghosts, who always go, a blind car among "
    "learned people shows their waiting."
)
POWER = (
    "Scenarios on which a paired test (McNemar, two-sided, p < 0.05) finds the difference some 8 times in 10, if the "
    "two drivers' collisions had nothing to do with each other, and if half of the better one's are the other's too."
)


def _name(cell: Cell) -> str:
    several = cell.jaywalk_multiplier != 0.25
    return f"{cell.driver} among {cell.pedestrians}" + (f" x {cell.jaywalk_multiplier:g}" if several else "")


def outcomes(cells: Sequence[Cell]) -> Table:
    """Return how episodes end."""
    columns = (
        "driver",
        "goal %",
        "collision %",
        "timeout %",
        "time to goal [s]",
        "delay [s]",
        "collisions per km",
        "moving %",
    )
    rows = []
    for cell in cells:
        rates = (shown(rate) for rate in (cell.goal_rate, cell.collision_rate, cell.timeout_rate))
        found = cell.summary[OUTCOMES]
        per_km, moving = shown(found.all.per_km, 1.0, 2), shown(found.moving.per_episode)
        times = (shown(cell.mean_time_to_goal, 1.0), shown(cell.mean_delay, 1.0, 2))
        rows.append((_name(cell), *rates, *times, per_km, moving))
    return Table(columns, tuple(rows))


def contacts(cells: Sequence[Cell]) -> Table:
    """Return the contacts by both rules."""
    columns = (
        "driver", "rule", "contacts %", "moving contacts %", "contacts", "standing", "front", "side", "rear",
        "car's speed [m/s]", "worst hundredth [m/s]",
    )  # fmt: skip
    rows = []
    for cell in cells:
        worst = shown(cell.summary[IMPACT_TAIL].worst_hundredth, 1.0)
        for rule, found in vars(cell.summary[MEASURED_CONTACTS]).items():
            counts = (found.contacts, found.standing, found.front, found.side, found.rear)
            shares = (shown(found.episodes), shown(found.moving))
            speeds = (shown(found.car_speed, 1.0), worst)
            rows.append((_name(cell), rule, *shares, *(f"{n:,}" for n in counts), *speeds))
    return Table(columns, tuple(rows))


def on_each_map(cells: Sequence[Cell]) -> Table:
    """Return how episodes end on each of several maps."""
    columns = ("driver", "map", "episodes", "goal %", "collision %", "timeout %", "time to goal [s]", "delay [s]")
    rows = []
    for cell, found in ((one, found) for one in cells for found in one.by_map):
        rates = (shown(rate) for rate in (found.goal_rate, found.collision_rate, found.timeout_rate))
        times = (shown(found.mean_time_to_goal, 1.0), shown(found.mean_delay, 1.0, 2))
        rows.append((_name(cell), found.map, f"{found.episodes:,}", *rates, *times))
    return Table(columns, tuple(rows))


def surrogates(cells: Sequence[Cell]) -> Table:
    """Return surrogate safety by type of encounter."""
    columns = (
        "driver", "encounter", "n", "TTC < 1.5 s %", "PET < 1.5 s %", "DRAC > 3.4 m/s² %", "5 % come nearer than [m]",
        "hit", "impact [m/s]", "MAIS3+ %", "fatal %",
    )  # fmt: skip
    rows = []
    for cell in cells:
        encounters = by_type(cell.summary[ENCOUNTERS])
        for kind, found in by_type(cell.summary[SURROGATES]).items():
            met, hit = encounters[kind], found.impact_speed
            shares = (shown(share) for share in (found.ttc_critical, found.pet_critical, found.drac_critical))
            nearest, impact = shown(met.minimum_gap, 1.0, 2), shown(hit, 1.0)
            risks = (shown(found.mais3), shown(found.fatal))
            rows.append((_name(cell), kind, f"{met.count:,}", *shares, nearest, f"{hit.count:,}", impact, *risks))
    return Table(columns, tuple(rows))


def near_misses(cells: Sequence[Cell]) -> Table:
    """Return the rate of contacts as observed, and extrapolated from near misses."""
    columns = ("driver", "near misses", "below [m]", "observed %", "extrapolated %", "check")
    rows = []
    for cell in cells:
        found = cell.summary[NEAR_MISSES]
        check = "the observed rate agrees" if found.agrees else "the observed rate contradicts it"
        if found.threshold is None:
            check = f"cannot be extrapolated: {found.problem}"
        below = NONE if found.threshold is None else f"{found.threshold:g}"
        rates = (shown(rate, digits=2) for rate in (found.observed, found.extrapolated))
        rows.append((_name(cell), f"{found.extrapolated.count:,}", below, *rates, check))
    return Table(columns, tuple(rows))


def attribution(cells: Sequence[Cell]) -> Table:
    """Return who is involved in the collisions, relative to exposure."""
    columns = (
        "driver", "crosswalk, jaywalk, sidewalk", "jaywalking's share of collisions %", "of crossings %",
        "rate ratio per crossing", "per second on the road", "per second within 20 m",
    )  # fmt: skip
    rows = []
    for cell in cells:
        found, ended = cell.summary[ATTRIBUTION], cell.summary[OUTCOMES]
        counts = (ended.crosswalk, ended.jaywalk, ended.sidewalk)
        ratios = (shown(risk.ratio, 1.0, 2) for risk in (found.per_crossing, found.per_second, found.per_second_near))
        shares = (shown(number) for number in (found.share, found.per_crossing.share))
        rows.append((_name(cell), ", ".join(f"{c.moving + c.standing:,}" for c in counts), *shares, *ratios))
    return Table(columns, tuple(rows))


def braking(cells: Sequence[Cell]) -> Table:
    """Return the time from road entry to braking."""
    columns = ("driver", "encounter", "median [s]", "brake", "never", "already", "standing")
    rows = []
    for cell in cells:
        for kind, encounters in by_type(cell.summary[ENCOUNTERS]).items():
            found = encounters.braking
            counts = (f"{count:,}" for count in (found.observed, found.censored, found.already, found.standing))
            rows.append((_name(cell), kind, shown(found.median, 1.0, 2), *counts))
    return Table(columns, tuple(rows))


def speeds(cells: Sequence[Cell]) -> Table:
    """Return the speed differential four ways, near jaywalkers minus near crosswalk users [m/s]."""
    columns = ("driver", "distance [m]", "frames", "encounters", "matched", "ghosts", "people minus ghosts")
    rows = []
    for cell, found in ((one, found) for one in cells for found in one.summary[SPEED_DIFFERENTIAL]):
        placebo = found.placebo
        gaps = [found.pooled.difference, found.by_encounter.difference]
        gaps += [found.matched, placebo.ghosts.difference, placebo.difference]
        rows.append((_name(cell), surprise.place(found), *(shown(gap, 1.0, 2) for gap in gaps)))
    return Table(columns, tuple(rows))


def power() -> Table:
    """Return the scenarios needed to show that two rates differ."""
    rows = [
        (f"{100 * a:g} and {100 * b:g}", *(f"{scenarios_needed(a, b, both=both):,}" for both in (None, min(a, b) / 2)))
        for a, b in TOLD_APART
    ]
    return Table(("collision rates %", "scenarios, unrelated", "scenarios, half in common"), tuple(rows))
