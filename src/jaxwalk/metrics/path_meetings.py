"""Measure what happens where a person's way and a car's path meet, from positions alone.

The metrics of the kerb need to know what a person decided. These need only what a camera sees, so recordings of a real
street and of ours are measured alike (``docs/real-recordings.md``). The *car's path* is what its rectangle covers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.metrics.conflict_areas import PET_LIMIT
from jaxwalk.metrics.counts import clustered_share
from jaxwalk.metrics.encounters import ENCOUNTERS, Encounters
from jaxwalk.metrics.metric import Metric, Rows, Sums, episodes_with
from jaxwalk.metrics.statistics import Estimate, quantile, ratio
from jaxwalk.metrics.surrogate import SURROGATES, Surrogates
from jaxwalk.metrics.values import without_nan
from jaxwalk.sim.events import distance, to_rectangle
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory

STILL = 0.5
"""A person slower than this stands [m/s] ..."""
STOP = 0.5
"""... and has stopped after standing this long without a break [s]."""
JUDGES = SimConfig.kerb_distance
"""A person has to judge the car this long a way before its path [m]: where ours do before a roadway."""


@dataclass(frozen=True)
class PathMeetings:
    """One row per encounter whose post-encroachment time exists; NaN stands for what doesn't exist."""

    episode: Int[np.ndarray, "meeting"]
    """Row of the episode."""
    waited: Bool[np.ndarray, "meeting"]
    """The person stopped in view of the car, before it entered the car's path."""
    offered: Float[np.ndarray, "meeting"]
    """The time until the car is abreast of the place, at its speed in the first frame in which the person is in view
    and at most `JUDGES` before the car's path [s]. NaN for a car that stands then or has passed."""
    approach_seen: Bool[np.ndarray, "meeting"]
    """The person was in view in the frame before that one too, so that it is the one in which people judge the car."""
    accepted: Float[np.ndarray, "meeting"]
    """If the person came first: the time that the car needed at its speed in the moment in which the person entered its
    path, to reach that place [s]. NaN for a car that stood then, and if nobody saw that moment: whoever is on the path
    when first seen has entered it before."""
    crossing_speed: Float[np.ndarray, "meeting"]
    """Mean speed of the person on the roadway [m/s]."""
    pet: Float[np.ndarray, "meeting"]
    """Post-encroachment time [s]: positive if the person came first."""
    min_distance: Float[np.ndarray, "meeting"]
    """Smallest distance between the centres [m]."""


@dataclass(frozen=True)
class PathMeetingSummary:
    """Numbers of all meetings; medians assume that meetings are independent."""

    waited: Estimate
    """Share who stopped before they entered the car's path."""
    pedestrian_first: Estimate
    """Share in which the person came first."""
    accepted: Estimate
    """Median accepted gap [s]."""
    crossing_speed: Estimate
    """Median crossing speed [m/s]."""
    pet: Estimate
    """Median post-encroachment time, without its sign [s]."""
    min_distance: Estimate
    """Median of the smallest distances between the centres [m]."""


def find_path_meetings(
    trajectory: Trajectory, encounters: Encounters, surrogates: Surrogates, config: SimConfig
) -> PathMeetings:
    """Return what happened in each encounter with a post-encroachment time.

    Args:
        trajectory: the trajectory in which the encounters were found.
        encounters: the encounters.
        surrogates: their surrogates, row by row.
        config: says how large car and body are, and below what speed a car stands.
    """
    rows = np.flatnonzero(~np.isnan(surrogates.pet)).tolist()
    stopped = _stopped(trajectory)
    entries = [_entry(trajectory, encounters, row, config) for row in rows]
    waited, offered, seen, accepted, speeds = [], [], [], [], []
    for row, (enters, arrives) in zip(rows, entries, strict=True):
        episode, ped = int(encounters.episode[row]), int(encounters.ped[row])
        stays = slice(encounters.enter[row], encounters.end[row] + 1), episode, ped
        waited.append(bool(stopped[:enters, episode, ped].any()))
        judges = _judges(trajectory, episode, ped, enters)
        seen.append(_seen_before(trajectory, episode, ped, judges))
        to_centre = config.car_length / 2 + config.body_radius
        offered.append(_time_to(trajectory, episode, judges, arrives, config, beyond=to_centre))
        first = surrogates.pet[row] > 0 and arrives > enters and _seen_before(trajectory, episode, ped, enters)
        accepted.append(_time_to(trajectory, episode, enters, arrives, config) if first else np.nan)
        speeds.append(float(distance(trajectory.ped_vx[stays], trajectory.ped_vy[stays]).mean()))
    return PathMeetings(
        episode=encounters.episode[rows],
        waited=np.array(waited, bool),
        offered=np.array(offered, float),
        approach_seen=np.array(seen, bool),
        accepted=np.array(accepted, float),
        crossing_speed=np.array(speeds, float),
        pet=surrogates.pet[rows].astype(float),
        min_distance=encounters.min_distance[rows].astype(float),
    )


def _stopped(trajectory: Trajectory) -> Bool[np.ndarray, "frame episode ped"]:
    """Return who has stood for the last `STOP` seconds."""
    stands = (distance(trajectory.ped_vx, trajectory.ped_vy) < STILL) & ~np.isnan(trajectory.ped_x)
    count, steps = np.cumsum(stands, axis=0), max(round(STOP / trajectory.dt), 1)
    before = np.zeros_like(count)
    before[steps:] = count[:-steps]
    return count - before == steps


def _entry(trajectory: Trajectory, encounters: Encounters, row: int, config: SimConfig) -> tuple[int, int]:
    """Return the first frame in which the person is on the car's path, and the one in which the car first covers it."""
    episode, ped, limit = int(encounters.episode[row]), int(encounters.ped[row]), round(PET_LIMIT / trajectory.dt)
    walked = np.arange(encounters.enter[row], encounters.end[row] + 1)
    driven = np.arange(encounters.start[row], min(encounters.end[row] + limit, trajectory.length[episode]) + 1)
    x, y = (getattr(trajectory, f"ped_{name}")[walked, episode, ped, None] for name in ("x", "y"))
    car = {name: getattr(trajectory, f"car_{name}")[driven, episode] for name in ("x", "y", "cos", "sin")}
    ahead, left = to_frame(x - car["x"], y - car["y"], car["cos"], car["sin"])
    covered = to_rectangle(ahead, left, config.car_length, config.car_width) < config.body_radius
    covered &= np.abs(walked[:, None] - driven) <= limit
    enters = int(covered.any(axis=1).argmax())
    return int(walked[enters]), int(driven[covered[enters].argmax()])


def _seen_before(trajectory: Trajectory, episode: int, ped: int, frame: int) -> bool:
    """Return whether the person and the car are also in view in the frame before."""
    return frame > 0 and not bool(np.isnan(trajectory.ped_x[frame - 1, episode, ped]))


def _judges(trajectory: Trajectory, episode: int, ped: int, enters: int) -> int:
    """Return the first frame in view in which the person is at most `JUDGES` before the place it enters later [m]."""
    x, y = (getattr(trajectory, f"ped_{name}")[: enters + 1, episode, ped] for name in ("x", "y"))
    left = np.append(np.cumsum(distance(np.diff(x), np.diff(y))[::-1])[::-1], 0.0)
    return int((left <= JUDGES).argmax())  # out of view the way left is NaN, so no frame before is taken


def _time_to(
    trajectory: Trajectory, episode: int, now: int, arrives: int, config: SimConfig, *, beyond: float = 0.0
) -> float:
    """Return the time to drive from where the car is in a frame to ``beyond`` metres past where it is in another [s].

    At its speed in the first frame. NaN for a car that stands, or is already past.
    """
    way = slice(min(now, arrives), max(now, arrives) + 1), episode
    driven = float(distance(np.diff(trajectory.car_x[way]), np.diff(trajectory.car_y[way])).sum())
    metres = beyond + (driven if arrives >= now else -driven)
    speed = float(trajectory.car_speed[now, episode])
    return metres / speed if speed >= config.moving_speed and metres >= 0 else np.nan


def measures(meetings: PathMeetings) -> dict[str, Float[np.ndarray, "meeting"]]:
    """Return the five measures that populations are compared in; a post-encroachment time has no sign here."""
    return {
        "waited": meetings.waited.astype(float),
        "accepted": meetings.accepted,
        "crossing_speed": meetings.crossing_speed,
        "pet": np.abs(meetings.pet),
        "min_distance": meetings.min_distance,
    }


def meeting_sums(rows: Rows) -> dict[str, np.ndarray]:
    """Return, per episode, how many meetings there were, who waited and who came first."""
    table = rows[PATH_MEETINGS]
    chosen = {"meetings": np.ones(len(table.episode), bool), "waited": table.waited, "first": table.pet > 0}
    return {name: np.bincount(table.episode[who], minlength=rows.episodes) for name, who in chosen.items()}


def summarise_path_meetings(rows: Rows, sums: Sums) -> PathMeetingSummary:
    """Return the numbers of all meetings."""
    own, episodes = sums[PATH_MEETINGS], episodes_with(rows, meeting_sums)["meetings"]

    def share(name: str) -> Estimate:
        return clustered_share(ratio(own[name], own["meetings"]), own["meetings"][0], episodes)

    def median(name: str) -> Estimate:
        return quantile(rows.values(lambda chunk: without_nan(measures(chunk[PATH_MEETINGS])[name])), 0.5)

    return PathMeetingSummary(
        waited=share("waited"),
        pedestrian_first=share("first"),
        accepted=median("accepted"),
        crossing_speed=median("crossing_speed"),
        pet=median("pet"),
        min_distance=median("min_distance"),
    )


PATH_MEETINGS = Metric(
    name="path_meetings",
    measure=lambda recording: find_path_meetings(
        recording.trajectory, recording[ENCOUNTERS], recording[SURROGATES], recording.config
    ),
    needs=(ENCOUNTERS, SURROGATES),
    columns=meeting_sums,
    summarise=summarise_path_meetings,
)
"""Not among the `METRICS` of every evaluation: name it, as in ``measure(trajectory, metrics=(PATH_MEETINGS,))``."""
