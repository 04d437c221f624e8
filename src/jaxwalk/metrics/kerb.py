"""Find the moments at which people at a kerb decide to wait or to go, and the stays at the kerb that they belong to.

A *kerb moment* is a frame in which a pedestrian at the kerb walks straight at a roadway. The next frame shows what the
pedestrian does, so an episode's last frame is no kerb moment. A *stay* is an unbroken row of kerb moments. The limits
below belong to the metrics: they must not change when people's observations or rewards change.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.metrics.crossings import real_frames, rows_of, runs
from jaxwalk.metrics.footprint import in_car_frame
from jaxwalk.metrics.metric import Finding
from jaxwalk.sim import events
from jaxwalk.sim.trajectory import Trajectory

NEAR = 40.0
"""A car is harmless if it is this far away or farther [m] ..."""
PAST = 2.5
"""... or more than this past the pedestrian [m]."""
FAST = 2.0
"""A nearer car, with the pedestrian ahead of it, is dangerous if it is faster than this [m/s] ..."""
CONFLICT = 2.5
"""... and would come closer than this if the pedestrian walked on [m]."""
DANGER, HARMLESS, OTHER = SETTINGS = range(3)
"""What the car is to a pedestrian at the kerb; an axis ``setting`` has this order."""


@dataclass(frozen=True)
class Kerb:
    """One row per kerb moment, ordered by episode, pedestrian and frame."""

    episode: Int[np.ndarray, "moment"]
    ped: Int[np.ndarray, "moment"]
    frame: Int[np.ndarray, "moment"]
    waited: Bool[np.ndarray, "moment"]
    distance: Float[np.ndarray, "moment"]
    """Between the centres of car and pedestrian [m]."""
    ahead: Float[np.ndarray, "moment"]
    """How far the pedestrian is ahead of the car, along its heading [m]."""
    speed: Float[np.ndarray, "moment"]
    """Speed of the car [m/s]."""
    miss: Float[np.ndarray, "moment"]
    """How close the centres would come if the pedestrian went on now and the car kept its velocity [m]."""
    setting: Int[np.ndarray, "moment"]
    """DANGER, HARMLESS or OTHER."""
    first: Int[np.ndarray, "stay"]
    """For each stay, its first row here (for ``ufunc.reduceat``)."""
    last: Int[np.ndarray, "stay"]
    """For each stay, its last row here."""


def find_kerb(trajectory: Trajectory) -> Kerb:
    """Find all kerb moments of a trajectory."""
    at_kerb = trajectory.at_kerb[:-1] & trajectory.enters_roadway[:-1]
    played = real_frames(trajectory)[1:, :, None]
    where = frame, episode, ped = rows_of(at_kerb & played)
    ahead, left = in_car_frame(trajectory, *where)
    distance = events.distance(ahead, left)
    speed, miss = trajectory.car_speed[frame, episode], trajectory.predicted_miss[where]
    danger = (distance < NEAR) & (ahead > 0) & (speed > FAST) & (miss < CONFLICT)
    harmless = (distance >= NEAR) | (ahead < -PAST)
    first, _ = runs(episode, ped, frame)
    return Kerb(
        episode=episode,
        ped=ped,
        frame=frame,
        waited=~trajectory.going[frame + 1, episode, ped],
        distance=distance,
        ahead=ahead,
        speed=speed,
        miss=miss,
        setting=np.where(danger, DANGER, np.where(harmless, HARMLESS, OTHER)),
        first=first,
        last=np.append(first[1:], len(frame))[: len(first)] - 1,
    )


KERB = Finding(name="kerb", measure=lambda recording: find_kerb(recording.trajectory))
