"""Episodes as records that a page can replay. Numbers are integers, stored as differences, which compress well.

``page/record.js`` reads the records.
"""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any

import numpy as np

from jaxwalk.metrics.braking import ONSET
from jaxwalk.metrics.crossings import Crossings, find_crossings
from jaxwalk.metrics.encounters import Encounters, find_encounters, gaps_on_road
from jaxwalk.sim.crossing_kind import JAYWALK, CrossingKind
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.sim.walking_paths import Paths

PER_METRE, PER_RADIAN = 100, 1000
"""Units of a record: positions in cm, speeds in cm/s, accelerations in cm/s2, headings in mrad."""
GOING, ON_ROADWAY, JAYWALKS, UNPERCEIVED = 1, 2, 4, 8
"""Bits of a pedestrian's state: it walks, it is between the kerbs, it has decided to jaywalk, the car doesn't perceive
it. The last one is never set in a world without perception."""

Record = dict[str, Any]


def make_records(
    trajectory: Trajectory, paths: Paths | None = None, routes: list[np.ndarray] | None = None
) -> list[str]:
    """Return every episode as text: a JSON record, deflated, in base64 (``docs/watching.md``).

    Args:
        trajectory: recorded episodes.
        paths: each pedestrian's planned path, ``(..., ped, episode)``; None shows no plans.
        routes: the car's lane route in each episode, ``(point, 2)`` [m]; None shows no routes.
    """
    crossings, steps = find_crossings(trajectory)
    gaps = gaps_on_road(trajectory, steps, SimConfig())  # no size of a body is shown
    encounters = find_encounters(trajectory, crossings, steps, gaps)
    packed = []
    for episode in range(len(trajectory.length)):
        record = _episode(trajectory, episode)
        if trajectory.parked is not None:
            record["parked"] = boxes_record(trajectory.parked_in(episode))
        if trajectory.perceived is not None:
            _add_last_seen(record, trajectory, episode)
        record["events"] = _events(trajectory, episode, crossings, encounters)
        record["route"] = None if routes is None else line_record(routes[episode])
        if paths is not None:
            record["paths"] = _plans(trajectory, episode, paths)
        packed.append(_pack(record))
    return packed


def _pack(record: Record) -> str:
    text = json.dumps(record, separators=(",", ":"), allow_nan=False)
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode("ascii")


def _differences(values: np.ndarray, per_unit: int) -> list[int]:
    """Return values as integers: the first one, then the change to each next one."""
    whole = np.round(np.asarray(values, np.float64) * per_unit).astype(np.int64)
    return np.diff(whole, prepend=0).tolist()


def line_record(points: np.ndarray) -> Record:
    """Return a polyline ``(point, 2)`` [m] as a record."""
    return {"x": _differences(points[:, 0], PER_METRE), "y": _differences(points[:, 1], PER_METRE)}


def _episode(t: Trajectory, e: int) -> Record:
    """Return the episode's goal and everything that moves."""
    frames = slice(int(t.length[e]) + 1)
    heading = np.unwrap(np.arctan2(t.car_sin[frames, e], t.car_cos[frames, e]))
    perceived = None if t.perceived is None else t.perceived[frames, e]
    state = state_bits(t.going[frames, e], t.on_roadway[frames, e], t.crossing[frames, e], perceived)
    return {
        "goal": [round(float(t.goal_x[e]), 2), round(float(t.goal_y[e]), 2)],
        "touched": np.flatnonzero(t.touched[e]).tolist() if t.collision[e] else [],
        "tendency": np.round(t.jaywalking_tendency[e].astype(float), 2).tolist(),
        "car": {
            "x": _differences(t.car_x[frames, e], PER_METRE),
            "y": _differences(t.car_y[frames, e], PER_METRE),
            "heading": _differences(heading, PER_RADIAN),
            "speed": _differences(t.car_speed[frames, e], PER_METRE),
            "acceleration": _differences(t.car_acceleration[frames, e], PER_METRE),
        },
        "people": [
            {
                "x": _differences(t.ped_x[frames, e, ped], PER_METRE),
                "y": _differences(t.ped_y[frames, e, ped], PER_METRE),
                "state": _differences(state[:, ped], 1),
            }
            for ped in range(t.ped_x.shape[2])
        ],
    }


def state_bits(
    going: np.ndarray, on_roadway: np.ndarray, crossing: np.ndarray, perceived: np.ndarray | None
) -> np.ndarray:
    """Return the bits of people's states from four columns of a `Trajectory` of one shape."""
    state = going * GOING + on_roadway * ON_ROADWAY + (crossing == JAYWALK) * JAYWALKS
    return state if perceived is None else state + ~perceived * UNPERCEIVED


def boxes_record(boxes: np.ndarray) -> Record:
    """Return the boxes of parked vehicles, ``(vehicle, column)``, as a record."""
    x, y, cos, sin, half_length, half_width = boxes.T
    sizes = {"length": _differences(2 * half_length, PER_METRE), "width": _differences(2 * half_width, PER_METRE)}
    return {**line_record(np.stack([x, y], axis=1)), "heading": _differences(np.arctan2(sin, cos), PER_RADIAN), **sizes}


def _add_last_seen(record: Record, t: Trajectory, e: int) -> None:
    """Add to each person where it was last seen, a point for each time that the car loses it, and how late that is."""
    columns = (t.perceived, t.last_seen_x, t.last_seen_y, t.last_seen_age)
    now, x, y, age = (np.asarray(column)[: int(t.length[e]) + 1, e] for column in columns)
    record["delay"] = round(float(age[now].min()) / t.dt) if now.any() else 0
    for ped, person in enumerate(record["people"]):
        lost = np.flatnonzero(now[:-1, ped] & ~now[1:, ped]) + 1
        person["lost"] = line_record(np.stack([x[lost, ped], y[lost, ped]], axis=1))


def _events(t: Trajectory, e: int, crossings: Crossings, encounters: Encounters) -> list[Record]:
    """Return the events for the timeline, in order of time; pedestrians count from 0."""
    found: list[Record] = []
    for row in np.flatnonzero(crossings.episode == e):
        ped, kind = int(crossings.ped[row]), CrossingKind(int(crossings.type[row])).word
        if crossings.entry_seen[row]:
            found.append({"frame": int(crossings.enter[row]), "what": kind, "ped": ped})
    for row in np.flatnonzero((encounters.episode == e) & (encounters.braking == ONSET)):
        onset = int(encounters.enter[row]) + round(float(encounters.braking_time[row]) / t.dt)
        found.append({"frame": onset, "what": "brake", "ped": int(encounters.ped[row])})
    ending = "collision" if t.collision[e] else "goal" if t.goal[e] else "timeout"
    touched = np.flatnonzero(t.touched[e]) if t.collision[e] else []
    found.append({"frame": int(t.length[e]), "what": ending, "ped": int(touched[0]) if len(touched) else None})
    return sorted(found, key=lambda event: event["frame"])


def _plans(t: Trajectory, e: int, paths: Paths) -> list[Record]:
    """Return each pedestrian's path, up to the goal that it is walking to at the end of the episode."""
    last = int(t.length[e])
    strides = np.hypot(np.diff(t.ped_x[: last + 1, e], axis=0), np.diff(t.ped_y[: last + 1, e], axis=0))
    return [_plan(paths, e, ped, float(walked)) for ped, walked in enumerate(strides.sum(axis=0))]


def _plan(paths: Paths, e: int, ped: int, walked: float) -> Record:
    """Return one path, with the legs that are ``jaywalks`` and the points that are ``goals``."""
    x, y = paths.x[:, ped, e], paths.y[:, ped, e]
    arrivals = paths.arrivals[:, ped, e]
    along = np.cumsum(np.hypot(np.diff(x), np.diff(y)))
    now = min(int(np.searchsorted(along, walked)), len(arrivals) - 1)
    legs = int(np.searchsorted(arrivals, arrivals[now], side="right"))
    goals = np.flatnonzero(np.diff(arrivals[: legs + 1])) + 1
    jaywalks = np.flatnonzero(paths.jaywalk[:legs, ped, e])
    line = line_record(np.stack([x[: legs + 1], y[: legs + 1]], axis=1))
    return {**line, "jaywalks": jaywalks.tolist(), "goals": goals.tolist()}
