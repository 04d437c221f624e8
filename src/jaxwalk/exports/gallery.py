"""The gallery of failures: the worst collisions and the nearest misses of an evaluation, as episodes to watch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import chain

import numpy as np

from jaxwalk.evaluation import (
    Incidents,
    ReplayError,
    counterfactuals,
    describe,
    episodes_at_once,
    find_hits,
    find_incidents,
    named,
    replay,
)
from jaxwalk.evaluation.batches import AT_ONCE
from jaxwalk.evaluation.episode_file import CONTACT_NAMES
from jaxwalk.evaluation.incidents import Situations
from jaxwalk.exports.replays import recording
from jaxwalk.interfaces import Policy
from jaxwalk.metrics import OUTCOMES, Rows
from jaxwalk.report.watched import Gallery, WatchedEpisode, WatchedIncident
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.viewer.drawn_map import DrawnMap
from jaxwalk.wording import counted

LEAD = 3.0
"""Time before an incident at which its replay starts [s]."""


@dataclass(frozen=True)
class Cast:
    """The policies that were evaluated, and where."""

    street: Street
    drivers: Mapping[str, Policy]
    populations: Mapping[str, Policy]
    seed: int
    """Seed of the scenarios."""


def gallery(cast: Cast, played: Mapping[tuple[str, str], Rows], *, most: int, say: Callable[[str], None]) -> Gallery:
    """Find the incidents, and record for each the episode under every driver.

    Args:
        cast: who was evaluated.
        played: the measured rows of each driver among each population.
        most: incidents of each kind (collisions, near misses) for each driver and population.
        say: called with a line of progress.

    Raises:
        ReplayError: a driver acts differently when the same scenario is played again.
    """
    say("    choosing incidents")
    found = {pair: find_incidents(rows, most=most) for pair, rows in played.items()}
    numbers = {
        people: sorted({int(n) for (_, among), some in found.items() if among == people for n in some.scenario})
        for people in cast.populations
    }
    document = recording(cast.street, cast.drivers, cast.populations, numbers, Drawn(cast.street, cast.seed), say)
    episodes = tuple(WatchedEpisode(**entry) for entry in document["episodes"])
    places = {(e.driver, e.pedestrians, e.scenario): k for k, e in enumerate(episodes)}

    def incidents_of(pair: tuple[str, str]) -> list[WatchedIncident]:
        collisions = f"    collisions of {pair[0]} among {pair[1]}"
        say(f"{collisions}: could they have been avoided? (compiles first, which takes a while)")

        def tell(done: int, count: int) -> None:
            say(f"{collisions}: {done:,} of {count:,} replayed")

        incidents = _incidents(cast, pair, played[pair], found[pair], places, tell)
        say(f"    {counted(len(incidents), 'incident')} of {pair[0]} among {pair[1]}")
        return incidents

    with ThreadPoolExecutor(AT_ONCE) as pool:  # most of the time is compiling, and each compilation uses one core
        incidents = tuple(chain.from_iterable(pool.map(incidents_of, found)))
    scenarios = max(rows.episodes for rows in played.values())
    return Gallery(
        dt=document["dt"],
        maps=tuple(DrawnMap(**drawn) for drawn in document["maps"]),
        episodes=episodes,
        lead=LEAD,
        most=most,
        scenarios=scenarios,
        incidents=incidents,
    )


def _incidents(
    cast: Cast,
    pair: tuple[str, str],
    rows: Rows,
    some: Incidents,
    places: Mapping[tuple[str, str, int], int],
    tell: Callable[[int, int], None],
) -> list[WatchedIncident]:
    """Return a description of each incident of a driver among a population; ``places`` are those of its episodes.

    ``tell`` is called with the number of collisions replayed so far, and the total.
    """
    if not len(some.scenario):
        return []
    street, driver, people = cast.street, cast.drivers[pair[0]], cast.populations[pair[1]]
    hits = some.scenario[some.collision].tolist()
    policies, source = {"driver": driver, "pedestrian": people}, Drawn(street, cast.seed)
    with named({"driver": pair[0], "pedestrian": pair[1]}):
        replayed = counterfactuals(street, policies, source, find_hits(rows).among(hits), progress=tell)
    labels = dict(zip(replayed.scenario.tolist(), replayed.label.tolist(), strict=True))
    how = situations(cast, pair, some, rows)
    return [
        WatchedIncident(
            episode=places[*pair, int(some.scenario[i])],
            kind="collision" if some.collision[i] else "near miss",
            contact=CONTACT_NAMES[some.contact[i]],
            moving=bool(some.moving[i]),
            ped=int(some.ped[i]),
            t=round(int(how.frame[i]) * rows.dt, 2),
            car=str(how.car[i]),
            side=str(how.side[i]),
            avoidable=labels.get(int(some.scenario[i])) if some.collision[i] else None,
            speed=_number(some.speed[i]),
            risk=_number(some.risk[i]),
            ttc=_number(some.ttc[i]),
            nearest=_number(some.nearest[i]),
        )
        for i in range(len(some.scenario))
    ]


def situations(cast: Cast, pair: tuple[str, str], some: Incidents, rows: Rows) -> Situations:
    """Replay incidents of a driver among a population, and describe them. Raise ReplayError if ``rows`` differ."""
    street, policies = cast.street, {"driver": cast.drivers[pair[0]], "pedestrian": cast.populations[pair[1]]}
    batch, found = episodes_at_once(street, policies), []
    for first in range(0, len(some.scenario), batch):
        part = some.some(slice(first, first + batch))
        trajectory = replay(street, policies, Drawn(street, cast.seed), part.scenario.tolist())
        if (trajectory.length != rows[OUTCOMES].steps[part.scenario]).any():
            raise ReplayError(f"{pair[0]} among {pair[1]} does not do the same again in the same scenario")
        found.append(vars(describe(part, trajectory, moving_speed=street.config.moving_speed)))
    return Situations(**{name: np.concatenate([one[name] for one in found]) for name in found[0]})


def _number(value: float) -> float | None:
    """Return a value for JSON, rounded to three digits; None for NaN and infinity."""
    return round(float(value), 3) if abs(value) < float("inf") else None
