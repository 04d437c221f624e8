"""Recordings for a page: chosen scenarios of an evaluation are played again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from jaxwalk.evaluation import episodes_at_once, jaywalk_multiplier, named, replay
from jaxwalk.interfaces import Policy
from jaxwalk.maps import as_network
from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.scenarios import Source
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.sim.walking_paths import Paths, walking_paths
from jaxwalk.viewer.record import make_records
from jaxwalk.viewer.replay import document, entries
from jaxwalk.wording import counted


def recording(
    street: Street,
    drivers: Mapping[str, Policy],
    populations: Mapping[str, Policy],
    numbers: Mapping[str, Sequence[int]],
    source: Source,
    say: Callable[[str], None] = lambda line: None,
) -> dict[str, Any]:
    """Return a page's document: every driver in the scenarios of a source that are named for each population.

    ``say`` is called with a line of progress.
    """
    batch = episodes_at_once(street, {})  # no driver has a smaller one
    found = [
        entry
        for people, policy in populations.items()
        for first in range(0, len(numbers[people]), batch)
        for entry in _entries(street, drivers, (people, policy), numbers[people][first : first + batch], source, say)
    ]
    return page_document(street, found)


def page_document(street: Street, entries: list[dict[str, Any]]) -> dict[str, Any]:
    """Return a page's document of entries, with the maps that they need."""
    used = sorted({entry["map"] for entry in entries})
    numbered = [{**entry, "map": used.index(entry["map"])} for entry in entries]
    return document(numbered, [as_network(street.maps[n]) for n in used], dt=street.world.rules.dt)


def _entries(
    street: Street,
    drivers: Mapping[str, Policy],
    people: tuple[str, Policy],
    numbers: Sequence[int],
    source: Source,
    say: Callable[[str], None],
) -> list[dict[str, Any]]:
    """Return the page's entries of scenarios, a batch at most, under every driver."""
    scenarios, _ = source.take(np.asarray(numbers))
    plans, found = _plans(street, scenarios), []
    for driver, policy in drivers.items():
        say(f"    recording {driver} among {people[0]}: {counted(len(numbers), 'episode')}")
        with named({"driver": driver, "pedestrian": people[0]}):
            trajectory = replay(street, {"driver": policy, "pedestrian": people[1]}, source, numbers)
        found += _entries_of(street, trajectory, plans, (driver, people[0]))
    return found


def entries_played(
    street: Street, source: Source, trajectory: Trajectory, names: tuple[str, str]
) -> list[dict[str, Any]]:
    """Return a page's entries of episodes that have been played; ``names`` are those of driver and population."""
    scenarios, _ = source.take(trajectory.scenario)
    return _entries_of(street, trajectory, _plans(street, scenarios), names)


class _Plans(NamedTuple):
    """What is drawn of scenarios beside what happens in them."""

    paths: Paths
    routes: list[np.ndarray]
    maps: list[int]


def _plans(street: Street, scenarios: Scenario) -> _Plans:
    config = street.config
    paths = walking_paths(street.world, scenarios, reach=config.horizon * config.dt * config.fastest)
    return _Plans(paths, routes_of(street, scenarios), np.asarray(scenarios.map).tolist())


def _entries_of(street: Street, trajectory: Trajectory, plans: _Plans, names: tuple[str, str]) -> list[dict[str, Any]]:
    records = make_records(trajectory, plans.paths, plans.routes)
    driver, people = names
    return entries(
        trajectory, records, plans.maps, driver=driver, pedestrians=people, multiplier=jaywalk_multiplier(street)
    )


def routes_of(street: Street, scenarios: Scenario) -> list[np.ndarray]:
    """Return the car's lane route in every scenario, with a point for each metre, ``(point, 2)`` [m]."""
    maps, every = jax.device_get(street.world.maps), round(1 / ROUTE_SPACING)
    chosen = list(zip(np.asarray(scenarios.map).tolist(), np.asarray(scenarios.route).tolist(), strict=True))
    return [
        np.stack([maps.route_x[at], maps.route_y[at]], axis=1)[: int(maps.route_length[at] / ROUTE_SPACING) + 1 : every]
        for at in chosen
    ]
