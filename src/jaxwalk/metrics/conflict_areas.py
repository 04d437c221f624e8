"""Where the paths of a car and a pedestrian meet, how far apart in time they were there, and how soon they would be.

The *conflict area* of an encounter: of all places on the driven path (from the encounter's start on) and on the walked
path (of the whole crossing) that lie within the collision distance of each other, the pair that was occupied at the
nearest times. Post-encroachment time (PET) and T2 both mean this area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.metrics.encounters import Encounters
from jaxwalk.sim.events import distance, touches
from jaxwalk.sim.trajectory import Trajectory

PET_LIMIT = 5.0
"""Who comes later than this after the other had no encroachment [s]: default of FHWA's SSAM (2008)."""


@dataclass(frozen=True)
class Steps:
    """One row per encounter and frame of its whole crossing, ordered by encounter, frame."""

    encounter: Int[np.ndarray, "step"]
    frame: Int[np.ndarray, "step"]
    episode: Int[np.ndarray, "step"]
    first: Int[np.ndarray, "encounter"]
    """For each encounter, its first row here (for ``ufunc.reduceat``)."""
    x: Float[np.ndarray, "step"]
    """Of the pedestrian [m]."""
    y: Float[np.ndarray, "step"]
    vx: Float[np.ndarray, "step"]
    """Of the pedestrian [m/s]."""
    vy: Float[np.ndarray, "step"]


def crossing_steps(trajectory: Trajectory, encounters: Encounters) -> Steps:
    """The frames of the encounters' crossings."""
    encounter, frame, first = _spans(encounters.enter, encounters.end)
    episode = encounters.episode[encounter].astype(np.int64)
    person = frame, episode, encounters.ped[encounter]
    names = ("x", "y", "vx", "vy")
    state = {name: getattr(trajectory, f"ped_{name}")[person].astype(np.float64) for name in names}
    return Steps(encounter=encounter, frame=frame, episode=episode, first=first, **state)


def conflict_areas(
    trajectory: Trajectory, encounters: Encounters, steps: Steps, collision_distance: float
) -> tuple[Float[np.ndarray, "encounter"], Int[np.ndarray, "encounter"]]:
    """How many frames after the pedestrian the car came (NaN if never), and the step of the pedestrian in the area.

    The definition is that of Saunier's Traffic Intelligence (``computePET``): of all pairs of frames whose places lie
    within the collision distance, the nearest in time; of equally near ones, pedestrian first, then the earliest.
    """
    lags, places = np.full(len(steps.first), np.nan), np.zeros(len(steps.first), np.int64)
    earliest, latest = encounters.start[steps.encounter], trajectory.length[steps.episode]
    limit = round(PET_LIMIT / trajectory.dt)
    left = np.flatnonzero(_near_path(trajectory, encounters, steps, collision_distance, limit))
    for lag in sorted(range(-limit, limit + 1), key=lambda lag: (abs(lag), -lag)):
        car = steps.frame[left] + lag
        there = (car >= earliest[left]) & (car <= latest[left])
        here, car = left[there], (car[there], steps.episode[left[there]])
        dx, dy = steps.x[here] - trajectory.car_x[car], steps.y[here] - trajectory.car_y[car]
        place = here[touches(dx, dy, collision_distance)]
        if not len(place):
            continue
        found, order = np.unique(steps.encounter[place], return_index=True)
        lags[found], places[found] = lag, place[order]
        left = left[np.isnan(lags[steps.encounter[left]])]
    return lags, places


def _near_path(trajectory: Trajectory, encounters: Encounters, steps: Steps, margin: float, limit: int) -> np.ndarray:
    """Which steps come within ``margin`` of the box around the path that the car drives in those ``limit`` frames."""
    # (most people cross far from the car's path: their steps need no search)
    end = np.minimum(encounters.end + limit, trajectory.length[encounters.episode])
    encounter, frame, first = _spans(encounters.start, end)
    near = np.ones(len(steps.frame), bool)
    for walked, driven in ((steps.x, trajectory.car_x), (steps.y, trajectory.car_y)):
        places = driven[frame, encounters.episode[encounter]]
        low, high = np.minimum.reduceat(places, first), np.maximum.reduceat(places, first)
        near &= (walked >= low[steps.encounter] - margin) & (walked <= high[steps.encounter] + margin)
    return near


def second_arrivals(
    trajectory: Trajectory,
    steps: Steps,
    met: Bool[np.ndarray, "step"],
    lag: Float[np.ndarray, "encounter"],
    place: Int[np.ndarray, "encounter"],
) -> Float[np.ndarray, "encounter"]:
    """Smallest T2 [s]: distance left to the conflict area over present speed, of who arrives second.

    Laureshyn, Svensson and Hydén (2010): along the path really taken, in every frame of the encounter up to that in
    which the first is in the area. A second that stands would never arrive (infinite).
    """
    own_lag = np.nan_to_num(lag).astype(np.int64)
    car_second = (own_lag > 0)[steps.encounter]
    driven = _path_length(trajectory.car_x, trajectory.car_y)
    walked = _path_length(steps.x, steps.y)
    car = steps.frame, steps.episode
    arrival = np.where(lag > 0, steps.frame[place] + own_lag, 0), steps.episode[place]
    to_drive = driven[arrival][steps.encounter] - driven[car]
    to_walk = walked[place][steps.encounter] - walked
    metres = np.where(car_second, to_drive, to_walk)
    speed = np.where(car_second, trajectory.car_speed[car], distance(steps.vx, steps.vy))
    seconds = np.divide(metres, speed, out=np.full(len(metres), np.inf), where=speed > 0)
    seconds = np.where(metres <= 0, 0.0, seconds)
    first_there = steps.frame[place] + np.minimum(own_lag, 0)
    waited_for = met & (steps.frame <= first_there[steps.encounter]) & ~np.isnan(lag)[steps.encounter]
    return finite(np.minimum.reduceat(np.where(waited_for, seconds, np.inf), steps.first))


def _spans(first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All frames from ``first`` to ``last``, span after span: which span, which frame; and where each span begins."""
    sizes = (last - first + 1).astype(np.int64)
    begin = np.cumsum(sizes) - sizes
    span = np.repeat(np.arange(len(sizes)), sizes)
    return span, np.arange(len(span)) + (first - begin)[span], begin


def _path_length(x: Float[np.ndarray, "frame ..."], y: Float[np.ndarray, "frame ..."]) -> np.ndarray:
    """Metres from the first frame to each."""
    step = np.zeros(x.shape)
    step[1:] = distance(np.diff(x, axis=0), np.diff(y, axis=0))
    return np.cumsum(step, axis=0)


def finite(values: np.ndarray) -> np.ndarray:
    """Infinite values as NaN."""
    return np.where(np.isfinite(values), values, np.nan)
