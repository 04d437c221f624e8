"""Measure how episodes end, how far and how long the car drove, and what kind each collision was."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.metrics.counts import proportion, rate
from jaxwalk.metrics.crossings import crossing_type, real_frames
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.metric import Metric, Rows, Sums
from jaxwalk.metrics.statistics import Estimate, Rate, interval, mean_of, ratio, standard_deviation
from jaxwalk.sim import events
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK, ContactKind
from jaxwalk.sim.trajectory import Trajectory

NO_CONTACT, SIDEWALK = ContactKind.NONE, ContactKind.SIDEWALK
"""Contact types besides CROSSWALK (1) and JAYWALK (2): nobody was touched; somebody off the roadway was touched."""
CONTACTS = (CROSSWALK, JAYWALK, SIDEWALK)
"""An axis named ``contact`` has the contact types in this order: index = contact - 1."""


@dataclass(frozen=True)
class Episodes:
    """One row per episode."""

    scenario: Int[np.ndarray, "episode"]
    steps: Int[np.ndarray, "episode"]
    """Steps played."""
    goal: Bool[np.ndarray, "episode"]
    collision: Bool[np.ndarray, "episode"]
    driven: Float[np.ndarray, "episode"]
    """Length of the car's path [m]."""
    contact: Int[np.ndarray, "episode"]
    """NO_CONTACT, CROSSWALK, JAYWALK or SIDEWALK: what the (nearest) touched pedestrian was doing."""
    contact_ped: Int[np.ndarray, "episode"]
    """That pedestrian; -1 without a collision."""
    impact_speed: Float[np.ndarray, "episode"]
    """Speed of the car in the last frame [m/s]; NaN without a collision."""
    moving: Bool[np.ndarray, "episode"]
    """Whether the car was moving in the collision; else somebody walked into a standing car."""


def measure_outcomes(trajectory: Trajectory, *, moving_speed: float) -> Episodes:
    """Return one row per episode. A car is moving if it drives at ``moving_speed`` [m/s] or more in the last frame."""
    collision = np.asarray(trajectory.collision, bool)
    last_speed = trajectory.car_speed[trajectory.length, np.arange(len(collision))]
    contact, ped = _contacts(trajectory)
    return Episodes(
        scenario=np.asarray(trajectory.scenario),
        steps=trajectory.length.astype(np.int32),
        goal=np.asarray(trajectory.goal, bool),
        collision=collision,
        driven=_driven(trajectory),
        contact=contact,
        contact_ped=ped,
        impact_speed=np.where(collision, last_speed, np.nan).astype(np.float32),
        moving=collision & (last_speed >= moving_speed),
    )


def _driven(trajectory: Trajectory) -> Float[np.ndarray, "episode"]:
    """Return the length of the car's path over the real frames [m]."""
    dx, dy = np.diff(trajectory.car_x, axis=0), np.diff(trajectory.car_y, axis=0)
    return np.where(real_frames(trajectory)[1:], events.distance(dx, dy), 0).sum(axis=0, dtype=np.float64)


def _contacts(trajectory: Trajectory) -> tuple[Int[np.ndarray, "episode"], Int[np.ndarray, "episode"]]:
    """Return the contact type and pedestrian of every collision; the nearest if several are touched."""
    contact, ped = np.zeros((2, len(trajectory.length)), np.int16)
    ped -= 1
    hit = np.flatnonzero(trajectory.collision)
    if not len(hit):  # there may be no people at all
        return contact, ped
    last = trajectory.length[hit]
    touched = trajectory.touched[hit]
    if not touched.any(axis=1).all():
        raise ValueError(f"episode {hit[~touched.any(axis=1)][0]} ends with a collision that touched nobody")
    dx = trajectory.ped_x[last, hit] - trajectory.car_x[last, hit][:, None]
    dy = trajectory.ped_y[last, hit] - trajectory.car_y[last, hit][:, None]
    walking = crossing_type(trajectory.crossing[last, hit], trajectory.on_crosswalk[last, hit])
    kind = np.where(trajectory.on_roadway[last, hit], walking, SIDEWALK)
    far = np.where(touched, events.distance(dx, dy), np.inf)
    # two may be equally near: the lowest code wins, so that the type does not depend on the order of the pedestrians
    first = np.lexsort((kind, far), axis=1)[:, 0]
    contact[hit], ped[hit] = kind[np.arange(len(hit)), first], first
    return contact, ped


@dataclass(frozen=True)
class CollisionRates:
    """How often collisions happen, on three scales."""

    per_episode: Rate
    per_km: Estimate
    """Collisions per kilometre driven; the count is the number of collisions."""
    per_encounter: Estimate
    """Collisions over encounters (a collision on a sidewalk has no encounter); the count is the number of
    collisions."""


@dataclass(frozen=True)
class Contact:
    """The collisions with people of one contact type."""

    share: Rate
    """Share of all collisions."""
    moving: int
    standing: int
    """Collisions in which somebody walked into a car below 0.5 m/s."""
    impact_speed: Estimate
    """Mean speed of the car [m/s]; the count is the number of collisions."""


@dataclass(frozen=True)
class Outcomes:
    """How episodes ended."""

    goal: Rate
    collision: Rate
    timeout: Rate
    time_to_goal: Estimate
    """Mean over the episodes that reached the goal [s]; the count is the number of those."""
    time_to_goal_error: float | None
    """Standard error of the mean time to goal [s]; None for fewer than two episodes."""
    kilometres: float
    """Distance driven in all episodes together."""
    encounters: int
    all: CollisionRates
    moving: CollisionRates
    """Collisions of a moving car only."""
    standing: CollisionRates
    """Collisions with a standing car only."""
    impact_speed: Estimate
    """Mean speed of the car over all collisions [m/s]."""
    crosswalk: Contact
    jaywalk: Contact
    sidewalk: Contact


def outcome_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return columns (episode,), columns by kind of collision (episode, 3), and columns by contact type (episode,
    3)."""
    table = rows[OUTCOMES]
    contacts = table.contact[:, None] == np.array(CONTACTS)
    return {
        "goals": table.goal,
        "goal_time": np.where(table.goal, table.steps * rows.dt, 0),
        "km": table.driven / 1000,
        "collisions": np.stack([table.collision, table.moving, table.collision & ~table.moving], axis=1),
        "contacts": contacts,
    }


def summarise_outcomes(rows: Rows, sums: Sums) -> Outcomes:
    """Return how the episodes ended."""
    own, encounters = sums[OUTCOMES], int(sums[ENCOUNTERS]["encounters"][0].sum())
    episodes, goals, collisions = rows.episodes, int(own["goals"][0]), int(own["collisions"][0, 0])
    steps = rows.values(lambda chunk: chunk[OUTCOMES].steps[chunk[OUTCOMES].goal])
    spread = standard_deviation(steps, steps.sum() / goals) * rows.dt / np.sqrt(goals) if goals > 1 else None
    kilometres = float(own["km"][0])
    kinds = [_collision_rates(int(hits), episodes, kilometres, encounters) for hits in own["collisions"][0]]
    contacts = [_contact(rows, kind, collisions) for kind in CONTACTS]
    return Outcomes(
        goal=proportion(goals, episodes),
        collision=proportion(collisions, episodes),
        timeout=proportion(episodes - goals - collisions, episodes),
        time_to_goal=interval(ratio(own["goal_time"], own["goals"]), goals),
        time_to_goal_error=None if spread is None else float(spread),
        kilometres=kilometres,
        encounters=encounters,
        all=kinds[0],
        moving=kinds[1],
        standing=kinds[2],
        impact_speed=_speeds(rows, lambda table: table.collision),
        crosswalk=contacts[0],
        jaywalk=contacts[1],
        sidewalk=contacts[2],
    )


def _collision_rates(count: int, episodes: int, kilometres: float, encounters: int) -> CollisionRates:
    """Return the rates of one kind of collision."""
    return CollisionRates(proportion(count, episodes), rate(count, kilometres), rate(count, encounters))


def _contact(rows: Rows, kind: int, collisions: int) -> Contact:
    """Summarise the collisions of one contact type."""
    speed = _speeds(rows, lambda table: table.contact == kind)
    moving = int(rows.total(lambda chunk: (chunk[OUTCOMES].moving & (chunk[OUTCOMES].contact == kind)).sum()))
    return Contact(proportion(speed.count, collisions), moving, speed.count - moving, speed)


def _speeds(rows: Rows, chosen: Callable[[Episodes], Bool[np.ndarray, "episode"]]) -> Estimate:
    """Return the mean speed [m/s] in the chosen collisions: at most one per episode, so they are independent."""
    speeds = rows.values(lambda chunk: chunk[OUTCOMES].impact_speed[chosen(chunk[OUTCOMES])])
    return mean_of(speeds, within=(0.0, math.inf))


OUTCOMES = Metric(
    name="outcomes",
    measure=lambda recording: measure_outcomes(recording.trajectory, moving_speed=recording.config.moving_speed),
    needs=(ENCOUNTERS,),
    columns=outcome_columns,
    summarise=summarise_outcomes,
    headline=True,
)
