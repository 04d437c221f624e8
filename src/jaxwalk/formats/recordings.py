"""Trajectories from any source as episodes for the metrics: each car's time in view is one episode with it as driver.

The pedestrians of an episode are all those in view during that time. Everything is resampled to one step. A pedestrian
out of view has NaN as position and is not on the roadway, so the metrics of encounters ignore it. Columns that the
table lacks (`jaxwalk.formats.tracks.OPTIONAL`) are computed from positions and speeds if possible; otherwise the
results leave out the metrics that need them (`jaxwalk.formats.measured`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from textwrap import shorten
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.formats.areas import Areas
from jaxwalk.formats.tracks import CAR, COLLISION, GOAL, PEDESTRIAN, Tracks, TracksError
from jaxwalk.formats.tracks import CROSSINGS as CHOICES
from jaxwalk.metrics import CROSSINGS, ENCOUNTERS, METRICS, Metric, Rows, measure
from jaxwalk.metrics.braking import UNSEEN
from jaxwalk.sim.sim_config import LARGEST, SimConfig
from jaxwalk.sim.trajectory import Trajectory

GAP = 1.0
"""A longer gap cuts a track: the road user is out of view, and counts as another one afterwards [s]."""
MOST_MOMENTS = 20_000_000
"""Largest number of steps times pedestrians in one episode, so that it fits into memory."""
NEARLY = 1e-6
"""Times that differ by less are equal [s]."""


@dataclass(frozen=True)
class CarInView:
    """A car's time in view, with the pedestrians in view during it."""

    tracks: Tracks
    """The recording."""
    car: Int[np.ndarray, "_"]
    """Rows of the car, in order of time."""
    people: tuple[Int[np.ndarray, "_"], ...]
    """Rows of each pedestrian in view during that time."""
    times: Float[np.ndarray, "frame"]
    """Times of the episode's frames [s]."""


def measure_tracks(
    tracks: Tracks, *, areas: Areas | None, config: SimConfig, metrics: Sequence[Metric[Any, Any]] = METRICS
) -> Iterator[Rows]:
    """Yield the rows of each episode of a recording.

    Without ``areas`` and without the optional columns that state it, every place is roadway and none is a crosswalk.
    A car has the size that the recording states, else that of ``config``. ``metrics`` must need `ENCOUNTERS`.
    """
    for view in cars_in_view(tracks, config):
        trajectory = trajectory_of(view, areas=areas, config=config)
        size = float(tracks.length[view.car[0]]), float(tracks.width[view.car[0]])
        stated = all(0 < metres <= LARGEST["car_length"] for metres in size)
        own = replace(config, car_length=size[0], car_width=size[1]) if stated else config
        yield _without_unseen_entries(measure(trajectory, config=own, metrics=metrics), trajectory)


def cars_in_view(tracks: Tracks, config: SimConfig) -> Iterator[CarInView]:
    """Yield every car's time in view, if the car moves during it or the recording states its ending.

    Raises TracksError if a road user has two rows at one time, or if there is too much to measure at once.
    """
    pieces = _pieces(tracks)
    of_type = {kind: [rows for rows in pieces if tracks.type[rows[0]] == kind] for kind in (CAR, PEDESTRIAN)}
    for car in of_type[CAR]:
        begin, end = tracks.t[car[0]], tracks.t[car[-1]]
        steps = int(np.floor((end - begin) / config.dt + NEARLY))
        parked = np.hypot(tracks.vx[car], tracks.vy[car]).max() < config.moving_speed
        if steps < 1 or (parked and "ending" not in tracks.known):
            continue
        people = [rows for rows in of_type[PEDESTRIAN] if tracks.t[rows[0]] <= end and tracks.t[rows[-1]] >= begin]
        if steps * max(len(people), 1) > MOST_MOMENTS:
            met = f"car {tracks.id[car[0]]} has {steps:,} steps among {len(people):,} people"
            raise TracksError(f"episode {tracks.episode}: {met}, too many to measure at once; cut the recording")
        yield CarInView(tracks, car, tuple(people), begin + np.arange(steps + 1) * config.dt)


def _pieces(tracks: Tracks) -> list[Int[np.ndarray, "_"]]:
    """Return the rows of every unbroken time in view, in order of id and time.

    Raises TracksError if a road user has two rows at one time.
    """
    if not len(tracks.t):
        return []
    order = np.lexsort((tracks.t, tracks.id))
    same, later = np.diff(tracks.id[order]) == 0, np.diff(tracks.t[order])
    if (twice := np.flatnonzero(same & (later <= 0))).size:
        who, when = tracks.id[order][twice[0]], tracks.t[order][twice[0]]
        raise TracksError(f"episode {tracks.episode}: road user {who} has two rows at {when:g} s; keep one of them")
    return np.split(order, np.flatnonzero(~same | (later > GAP)) + 1)


def trajectory_of(view: CarInView, *, areas: Areas | None, config: SimConfig) -> Trajectory:
    """Return a car's time in view as a trajectory of one episode."""
    length, known = len(view.times) - 1, view.tracks.known
    ending = known["ending"][view.car[-1]] if "ending" in known else ""
    touched = [bool(known["touched"][rows].any()) if "touched" in known else False for rows in view.people]
    tau = [known["jaywalking_tendency"][rows[0]] if "jaywalking_tendency" in known else np.nan for rows in view.people]
    goal = {name: np.array([known[name][view.car[-1]] if name in known else np.nan]) for name in ("goal_x", "goal_y")}
    columns = _car(view, config) | {name: x[:, None] for name, x in _people(view, areas).items()}
    return Trajectory(
        dt=config.dt,
        scenario=np.array([view.tracks.episode]),
        length=np.array([length]),
        goal=np.array([ending == GOAL]),
        collision=np.array([ending == COLLISION]),
        touched=np.array([touched], bool),
        jaywalking_tendency=np.array([tau], float),
        **goal,
        **columns,
    )


def _car(view: CarInView, config: SimConfig) -> dict[str, np.ndarray]:
    """Return the car's columns, each (frame, 1). It moves along its heading, or backwards."""
    tracks, rows, times = view.tracks, view.car, view.times
    x, y, vx, vy = (_between(times, tracks.t[rows], getattr(tracks, name)[rows]) for name in ("x", "y", "vx", "vy"))
    heading = _between(times, tracks.t[rows], np.unwrap(tracks.heading[rows]))
    cos, sin = np.cos(heading).astype(x.dtype), np.sin(heading).astype(x.dtype)
    forwards = np.where(vx * cos + vy * sin < 0, -1, 1).astype(x.dtype)
    speed = np.hypot(vx, vy)
    if "speed" in tracks.known:
        speed = _between(times, tracks.t[rows], tracks.known["speed"][rows])
    acceleration = np.append(0.0, np.diff(speed) / config.dt)
    if "acceleration" in tracks.known:
        acceleration = _between(times, tracks.t[rows], tracks.known["acceleration"][rows])
    columns = {"x": x, "y": y, "cos": forwards * cos, "sin": forwards * sin}
    columns |= {"speed": speed, "acceleration": acceleration}
    return {f"car_{name}": values[:, None] for name, values in columns.items()}


def _people(view: CarInView, areas: Areas | None) -> dict[str, np.ndarray]:
    """Return the pedestrians' columns, each (frame, ped)."""
    tracks, times = view.tracks, view.times
    known = tracks.known if areas or "on_roadway" in tracks.known else {}
    shape = len(times), len(view.people)

    def table(values: np.ndarray, between=_between) -> np.ndarray:
        columns = [between(times, tracks.t[rows], values[rows]) for rows in view.people]
        return np.stack(columns, axis=1) if columns else np.zeros(shape, values.dtype)

    x, y, vx, vy = (table(getattr(tracks, name)) for name in ("x", "y", "vx", "vy"))
    seen = ~np.isnan(x)
    on_roadway, on_crosswalk = areas.locate(x, y) if areas else (seen, np.zeros(shape, bool))
    columns = {
        "on_roadway": on_roadway, "on_crosswalk": on_crosswalk, "crossing": np.zeros(shape, np.int8),
        "decisions": np.zeros(shape, np.int16), "at_kerb": np.zeros(shape, bool), "going": np.ones(shape, bool),
        "enters_roadway": np.zeros(shape, bool), "predicted_miss": np.full(shape, np.nan),
    }  # fmt: skip
    for name in columns.keys() & known.keys():
        if name == "crossing":
            columns[name] = table(_crossing_numbers(known[name]), _nearest)
        else:
            columns[name] = table(known[name], _between if name == "predicted_miss" else _nearest)
    for name in ("on_roadway", "on_crosswalk", "at_kerb"):
        columns[name] = columns[name] & seen
    still = {name: np.nan_to_num(values) for name, values in (("ped_vx", vx), ("ped_vy", vy))}
    return {"ped_x": x, "ped_y": y, **still, **columns}


def _crossing_numbers(words: np.ndarray) -> Int[np.ndarray, "row"]:
    """Return the numbers of `jaxwalk.sim.trajectory` for words. Raises TracksError for an unknown word."""
    strange = set(words.tolist()) - set(CHOICES)  # np.unique would need the memory of the longest word in every row
    if strange:
        shown = shorten(repr(min(strange)), 100)
        raise TracksError(f"column crossing: {shown}; it must be one of {', '.join(CHOICES)}")
    return np.select([words == word for word in CHOICES], range(len(CHOICES))).astype(np.int8)


def _between(times: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Interpolate values at ``t`` linearly to ``times``; NaN outside."""
    inside = (times >= t[0] - NEARLY) & (times <= t[-1] + NEARLY)
    return np.where(inside, np.interp(times, t, values), np.nan).astype(values.dtype)


def _nearest(times: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return values at ``times``, each from the nearest ``t``."""
    return values[np.searchsorted((t[1:] + t[:-1]) / 2, times)]


def _without_unseen_entries(rows: Rows, trajectory: Trajectory) -> Rows:
    """Mark pedestrians who came into view on the roadway: their entry, and braking for it, were not observed."""
    seen = ~np.isnan(trajectory.ped_x[:, 0])

    def unseen(enter: np.ndarray, ped: np.ndarray) -> Bool[np.ndarray, "row"]:
        return (enter == 0) | ~seen[np.maximum(enter - 1, 0), ped]

    late = unseen(rows[ENCOUNTERS].enter, rows[ENCOUNTERS].ped)
    encounters = replace(
        rows[ENCOUNTERS],
        braking=np.where(late, UNSEEN, rows[ENCOUNTERS].braking).astype(np.int8),
        braking_time=np.where(late, np.nan, rows[ENCOUNTERS].braking_time),
    )
    found = rows[CROSSINGS]
    crossings = replace(found, entry_seen=found.entry_seen & ~unseen(found.enter, found.ped))
    return rows.having(ENCOUNTERS, encounters).having(CROSSINGS, crossings)
