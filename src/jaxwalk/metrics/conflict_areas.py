"""Find where the paths of a car and a pedestrian meet, and the times at which each was or would be there.

The *conflict area* of an encounter is a pair of places: one on the path that the car drove (from the encounter's start
on), one on the path that the pedestrian walked (over the whole crossing). At these places the pedestrian's body would
overlap the car's rectangle. Of all such pairs it is the one whose places were occupied at the nearest times.
Post-encroachment time (PET) and T2 both refer to this area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.metrics.encounters import Encounters
from jaxwalk.metrics.footprint import reach
from jaxwalk.sim.events import distance, to_rectangle, touches
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory

PET_LIMIT = 5.0
"""If the second arrives later than this, there was no encroachment [s]: default of FHWA's SSAM (2008)."""


@dataclass(frozen=True)
class Steps:
    """The frames of the whole crossing of each encounter: one row per frame, ordered by encounter and frame."""

    encounter: Int[np.ndarray, "step"]
    frame: Int[np.ndarray, "step"]
    episode: Int[np.ndarray, "step"]
    first: Int[np.ndarray, "encounter"]
    """For each encounter, its first row here (for ``ufunc.reduceat``)."""
    x: Float[np.ndarray, "step"]
    """Position of the pedestrian [m]."""
    y: Float[np.ndarray, "step"]
    vx: Float[np.ndarray, "step"]
    """Velocity of the pedestrian [m/s]."""
    vy: Float[np.ndarray, "step"]


def crossing_steps(trajectory: Trajectory, encounters: Encounters) -> Steps:
    """Return the frames of the encounters' crossings."""
    encounter, frame, first = _spans(encounters.enter, encounters.end)
    episode = encounters.episode[encounter].astype(np.int64)
    person = frame, episode, encounters.ped[encounter]
    names = ("x", "y", "vx", "vy")
    state = {name: getattr(trajectory, f"ped_{name}")[person].astype(np.float64) for name in names}
    return Steps(encounter=encounter, frame=frame, episode=episode, first=first, **state)


def conflict_areas(
    trajectory: Trajectory, encounters: Encounters, steps: Steps, config: SimConfig
) -> tuple[Float[np.ndarray, "encounter"], Int[np.ndarray, "encounter"]]:
    """Return how many frames after the pedestrian the car came (NaN if never), and the pedestrian's step in the area.

    The definition is that of Saunier's Traffic Intelligence (``computePET``): among all pairs of frames whose places
    overlap, take the nearest in time. Among equals, take pedestrian first, then the earliest.
    """
    lags, places = np.full(len(steps.first), np.nan), np.zeros(len(steps.first), np.int64)
    earliest = encounters.start[steps.encounter] - steps.frame
    latest = trajectory.length[steps.episode] - steps.frame
    columns = (trajectory.car_x, trajectory.car_y, trajectory.car_cos, trajectory.car_sin)
    car_x, car_y, cos, sin = (column.ravel() for column in columns)
    episodes, limit = len(trajectory.length), round(PET_LIMIT / trajectory.dt)
    moment = steps.frame * episodes + steps.episode
    left = np.flatnonzero(_near_path(trajectory, encounters, steps, reach(config), limit))
    for lag in sorted(range(-limit, limit + 1), key=lambda lag: (abs(lag), -lag)):
        here = left[(earliest[left] <= lag) & (lag <= latest[left])]
        car = moment[here] + lag * episodes
        dx, dy = steps.x[here] - car_x[car], steps.y[here] - car_y[car]
        near = touches(dx, dy, reach(config))  # few are: only these are turned into the car's frame
        here, car = here[near], car[near]
        ahead, aside = to_frame(dx[near], dy[near], cos[car], sin[car])
        place = here[to_rectangle(ahead, aside, config.car_length, config.car_width) < config.body_radius]
        if not len(place):
            continue
        found, order = np.unique(steps.encounter[place], return_index=True)
        lags[found], places[found] = lag, place[order]
        left = left[np.isnan(lags[steps.encounter[left]])]
    return lags, places


def _near_path(trajectory: Trajectory, encounters: Encounters, steps: Steps, margin: float, limit: int) -> np.ndarray:
    """Return which steps come within ``margin`` of the bounding box of the car's path in those ``limit`` frames."""
    # most people cross far from the car's path: this skips the search for them
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
    """Return the smallest T2 [s]: the second road user's distance to the conflict area, divided by its current speed.

    Laureshyn, Svensson and Hydén (2010): along the path that was really taken, over the frames of the encounter until
    the first road user is in the area. T2 is infinite for a second road user who stands still.
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
    """Return all frames from ``first`` to ``last``, span after span: its span, its frame, and where each span
    begins."""
    sizes = (last - first + 1).astype(np.int64)
    begin = np.cumsum(sizes) - sizes
    span = np.repeat(np.arange(len(sizes)), sizes)
    return span, np.arange(len(span)) + (first - begin)[span], begin


def _path_length(x: Float[np.ndarray, "frame ..."], y: Float[np.ndarray, "frame ..."]) -> np.ndarray:
    """Return the path length from the first frame to each frame [m]."""
    step = np.zeros(x.shape)
    step[1:] = distance(np.diff(x, axis=0), np.diff(y, axis=0))
    return np.cumsum(step, axis=0)


def finite(values: np.ndarray) -> np.ndarray:
    """Return the values with NaN in place of infinity."""
    return np.where(np.isfinite(values), values, np.nan)
