"""The first screen of a report: the verdict, what to watch, how the drivers stand, exposure, limits and thresholds."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import urlencode

from jaxwalk.evaluation import Cell
from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.metrics import FEWEST_SEEDS, OUTCOMES
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report import reversals
from jaxwalk.report.decision import Decision, Evidence, Training, decide
from jaxwalk.report.material import ALWAYS_GO, GAP_ACCEPTANCE, LEARNED, Material
from jaxwalk.report.sentences import Driven, Sentences, say
from jaxwalk.report.table import NONE, shown
from jaxwalk.report.validity import Said, hit_rule, limits, thresholds
from jaxwalk.report.watched import Gallery, WatchedEpisode, WatchedIncident
from jaxwalk.wording import counted, first_of

WORST = 5
"""Incidents on the first screen."""
SHOWN = 6
"""Drivers that the first screen shows at once; more are unfolded."""


@dataclass(frozen=True)
class DriverLine:
    """How a driver stands."""

    driver: str
    standing: str
    hits: tuple[tuple[str, str, str], ...]
    """For each population: the share of scenarios with a hit, the mean speed of the car at hits [m/s], and the cell, as
    in ``co-trained among learned``."""
    collides: str
    """Share of scenarios that end in any collision, on average over populations."""
    arrives: str
    """Share of scenarios in which it arrives, on average over populations."""
    times_out: str
    """Share of scenarios in which it runs out of time, on average over populations."""
    delay: str
    """Mean delay [s], on average over populations."""


@dataclass(frozen=True)
class ToWatch:
    """An incident to watch."""

    number: int
    """Its place among the gallery's."""
    address: str
    """Where the page shows it."""
    what: str
    who: str


@dataclass(frozen=True)
class FirstScreen:
    """What a reader sees first."""

    verdict: Sentences
    lines: tuple[DriverLine, ...]
    """The drivers that are shown at once, the report's subject among them."""
    folded: tuple[DriverLine, ...]
    """The other drivers."""
    populations: tuple[str, ...]
    worst: tuple[ToWatch, ...]
    worst_of: str
    """Who did that; empty if there is nothing to watch."""
    watchable: int
    """Number of their incidents in the gallery, of which ``worst`` are the first ones."""
    hit: str
    """What a contact of the moving car is in this world, in words."""
    exposure: tuple[Said, ...]
    limits: tuple[Said, ...]
    thresholds: tuple[Said, ...]
    paper: str
    """What reverses of the paper's findings; empty if the report doesn't repeat its experiment."""


def first_screen(material: Material) -> FirstScreen:
    """Return the first screen of a report."""
    evidence, driven = evidence_of(material), driven_in(material)
    decision = decide(evidence)
    worst, worst_of, watchable = to_watch(material.gallery, material.subject)
    sim = material.results.street.sim if material.results.street else None
    lines = [_line(material, evidence, decision, driver) for driver in decision.order]
    others = [driver for driver in decision.order if driver != material.subject]
    at_once = {material.subject, *others[: SHOWN - 1]}
    return FirstScreen(
        verdict=say(evidence, decision, driven),
        lines=tuple(line for line in lines if line.driver in at_once),
        folded=tuple(line for line in lines if line.driver not in at_once),
        populations=evidence.populations,
        worst=worst,
        worst_of=worst_of,
        watchable=watchable,
        hit=hit_rule(sim),
        exposure=_exposure(evidence, driven),
        limits=limits(sim),
        thresholds=thresholds(sim),
        paper=reversals.sentence(reversals.claims(material)),
    )


def evidence_of(material: Material) -> Evidence:
    """Return what the results say about the drivers' safety."""
    cells = [(driver, people) for driver in material.drivers for people in material.populations]
    return Evidence(
        drivers=material.drivers,
        populations=material.populations,
        hits={cell: _hits(material, *cell) for cell in cells},
        goals={cell: material.over_seeds(*cell).goal_rate.mean for cell in cells},
        compared=material.results.every_two,
        training=training_of(material),
        seeds=len(material.training_seeds),
        timeouts={cell: material.over_seeds(*cell).timeout_rate.mean for cell in cells},
        delays={cell: material.over_seeds(*cell).mean_delay.mean for cell in cells},
    )


def _hits(material: Material, driver: str, people: str) -> Interval:
    """Return the share of scenarios with a hit; of several training seeds their mean, without an interval."""
    cells = _cells(material, driver, people)
    return _mean([Interval.of(cell.summary[OUTCOMES].moving.per_episode) for cell in cells])


def speed_at_hits(material: Material, driver: str, people: str) -> Interval:
    """Return the mean speed of the car at hits [m/s]; of several training seeds their mean, without an interval.

    Hits are collisions of the moving car: contacts by the world's rule. Two people who are hit at once
    count twice. None without hits, and in results that don't say what the rule was.
    """
    street = material.results.street
    if street is None:
        return Interval(None, None, None)
    contacts = [cell.summary[MEASURED_CONTACTS] for cell in _cells(material, driver, people)]
    return _mean([Interval.of(getattr(found, street.sim.contact).car_speed) for found in contacts])


def _cells(material: Material, driver: str, people: str) -> list[Cell]:
    """Return the cells of a driver and a population: one for each training seed."""
    return [cell for cell in material.results.cells if (cell.driver, cell.pedestrians) == (driver, people)]


def _mean(found: list[Interval]) -> Interval:
    """Return the only number, or the mean of several without an interval."""
    if len(found) == 1:
        return found[0]
    values = [one.value for one in found if one.value is not None]
    return Interval(sum(values) / len(values) if values else None, None, None)


def training_of(material: Material) -> Training:
    """Return what is known about the training of the drivers."""
    if material.several:
        return "enough" if len(material.training_seeds) >= FEWEST_SEEDS else "few"
    kinds = {origin.kind for origin in material.results.drivers}
    if kinds == {"rule"}:
        return "none"
    return "unknown" if kinds and kinds <= {"rule", "Python class"} else "one"  # a class may hold a network


def driven_in(material: Material) -> Driven:
    """Return how much was driven."""
    results = material.results
    found = [cell.summary[OUTCOMES] for cell in results.cells]
    street = results.street
    return Driven(
        scenarios=results.scenarios.count,
        seed=results.scenarios.seed,
        kilometres=sum(one.kilometres for one in found),
        encounters=sum(one.encounters for one in found),
        people=None if street is None else street.sim.pedestrians,
        streets=() if street is None else tuple(found.name for found in street.maps),
    )


def _exposure(evidence: Evidence, driven: Driven) -> tuple[Said, ...]:
    drivers = counted(len(evidence.drivers), "driver")
    found = [
        Said(
            "Scenarios",
            f"{driven.scenarios:,} for each of {drivers} among {first_of(evidence.populations, 'population')}",
        ),
        Said("Driven", f"{driven.kilometres:,.1f} km, with {counted(driven.encounters, 'encounter')}"),
    ]
    if driven.streets:
        streets = f"{len(driven.streets):,}: {first_of(driven.streets, 'street')}"
        found += [Said("Streets", streets), Said("People", f"{driven.people} in each scenario")]
    known = [f"{name} {POPULATIONS[name]}" for name in evidence.populations if name in POPULATIONS]
    if known:
        found.append(Said("Populations", "; ".join(known)))
    return tuple(found)


POPULATIONS = {
    ALWAYS_GO: "never wait for the car",
    LEARNED: "have learned when to wait",
    GAP_ACCEPTANCE: "wait for a gap that is long enough",
}
"""What the people of the usual populations do."""


def _line(material: Material, evidence: Evidence, decision: Decision, driver: str) -> DriverLine:
    delays = [material.over_seeds(driver, people).mean_delay.mean.value for people in evidence.populations]
    known = [delay for delay in delays if delay is not None]
    hits = tuple(
        (
            shown(evidence.hits[driver, people]),
            shown(speed_at_hits(material, driver, people), 1.0, 1),
            f"{driver} among {people}",
        )
        for people in evidence.populations
    )
    rates = {
        (driver, people): material.over_seeds(driver, people).collision_rate.mean for people in evidence.populations
    }
    return DriverLine(
        driver=driver,
        standing=decision.standing(driver),
        hits=hits,
        collides=shown(Interval(evidence.mean(rates, driver), None, None)),
        arrives=shown(Interval(evidence.mean(evidence.goals, driver), None, None)),
        times_out=shown(Interval(evidence.mean(evidence.timeouts, driver), None, None)),
        delay=f"{sum(known) / len(known):.2f}" if known else NONE,
    )


def to_watch(gallery: Gallery | None, subject: str) -> tuple[tuple[ToWatch, ...], str, int]:
    """Return the worst incidents of a driver, who did them, and how many there are; of all drivers, if it has none."""
    if gallery is None or not gallery.incidents:
        return (), "", 0
    mine = [(n, one) for n, one in enumerate(gallery.incidents) if gallery.episodes[one.episode].driver == subject]
    found = sorted(mine or enumerate(gallery.incidents), key=lambda one: _order(one[1]))
    worst = tuple(_to_watch(gallery, *one) for one in found[:WORST])
    return worst, subject if mine else "all drivers", len(found)


def _order(incident: WatchedIncident) -> tuple[bool, float]:
    """Return by what incidents are sorted: collisions by the risk of an injury, then near misses by time."""
    if incident.kind == "collision":
        return False, -(incident.risk or 0.0)
    return True, float("inf") if incident.ttc is None else incident.ttc


def _to_watch(gallery: Gallery, number: int, incident: WatchedIncident) -> ToWatch:
    episode = gallery.episodes[incident.episode]
    start = max(0.0, incident.t - gallery.lead)
    parts = {
        "episode": episode.scenario,
        "driver": episode.driver,
        "pedestrians": episode.pedestrians,
        "t": f"{start:.1f}",
    }
    who = f"{PEOPLE.get(incident.contact, incident.contact)} {incident.side}, car {incident.car}"
    return ToWatch(
        number, f"#{urlencode(parts)}", _how(incident), f"{_cell(episode)}, scenario {episode.scenario}: {who}"
    )


PEOPLE = {"jaywalk": "jaywalker", "crosswalk": "crosswalk user", "sidewalk": "pedestrian on the sidewalk"}
"""What people were doing, in words, as the gallery says it."""


def _how(incident: WatchedIncident) -> str:
    """Return how bad an incident is."""
    if incident.kind != "collision":
        time = "" if incident.ttc is None else f", {incident.ttc:.1f} s to collision"
        return f"Near miss{time}"
    if not incident.moving:
        return "Walked into the standing car"
    speed = "" if incident.speed is None else f" at {incident.speed:.1f} m/s"
    risk = "" if incident.risk is None else f", {100 * incident.risk:.0f} % risk of a serious injury"
    return f"Hit{speed}{risk}"


def _cell(episode: WatchedEpisode) -> str:
    return f"{episode.driver} among {episode.pedestrians}"
