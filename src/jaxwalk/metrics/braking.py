"""Find when the car begins to brake for a pedestrian who has entered the road (spec: braking onset).

A command belongs to the step that led to its frame: the command of frame k answers what was seen in frame k - 1.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.metrics.crossings import real_frames
from jaxwalk.sim import events
from jaxwalk.sim.trajectory import Trajectory

NEVER, ONSET, ALREADY, STANDING, UNSEEN = range(5)
NAMES = ("never", "onset", "already", "standing", "unseen")
"""How the car braked in an encounter.

``never``: it did not begin to brake while the pedestrian was on the road (censored). ``onset``: it did. ``already``: it
was braking when the pedestrian entered. ``standing``: it was too slow to brake then (1 m/s or less). ``unseen``: the
episode began with the pedestrian on the road. Only the first two have a time.
"""


def braking_times(
    trajectory: Trajectory,
    *,
    episode: Int[np.ndarray, "encounter"],
    enter: Int[np.ndarray, "encounter"],
    last: Int[np.ndarray, "encounter"],
) -> tuple[Int[np.ndarray, "encounter"], Float[np.ndarray, "encounter"]]:
    """Return what the car did after each road entry, and the time from entry to braking (or to the last frame) [s].

    Args:
        trajectory: the recorded episodes.
        episode: the episode of each encounter.
        enter: first frame of the pedestrian on the roadway.
        last: last frame of the pedestrian on the roadway; later braking does not count for this crossing.
    """
    onset, braking = _held_braking(trajectory)
    after = _next(onset)[enter + 1, episode]  # the first command that can answer frame `enter` leads to the next frame
    status = np.where(after <= last, ONSET, NEVER)
    status[braking[enter, episode]] = ALREADY
    status[trajectory.car_speed[enter, episode] <= events.BRAKING_MIN_SPEED] = STANDING
    status[enter == 0] = UNSEEN
    until = np.where(status == ONSET, after - 1, last)
    seconds = np.where(status <= ONSET, (until - enter) * trajectory.dt, np.nan)
    return status.astype(np.int8), seconds


def _held_braking(
    trajectory: Trajectory,
) -> tuple[Bool[np.ndarray, "frame episode"], Bool[np.ndarray, "frame episode"]]:
    """Return which frames begin 0.3 s of braking by a car above 1 m/s, and which frames such held braking covers.

    Braking does not count as held if the episode ends before 0.3 s have passed.
    """
    hold = max(1, int(np.ceil(events.BRAKING_HOLD / trajectory.dt - 1e-6)))
    commanded = (trajectory.car_acceleration <= events.BRAKING) & real_frames(trajectory)
    commanded[0] = False  # there is no command before the start
    before_or_after = np.zeros((hold - 1, commanded.shape[1]), bool)
    held = np.asarray(_windows(np.concatenate([commanded, before_or_after]), hold).all(axis=-1))
    braking = np.asarray(_windows(np.concatenate([before_or_after, held]), hold).any(axis=-1))
    fast = np.zeros_like(held)
    fast[1:] = trajectory.car_speed[:-1] > events.BRAKING_MIN_SPEED
    return held & fast, braking


def _windows(frames: np.ndarray, size: int) -> np.ndarray:
    """Return ``size`` consecutive frames from each frame on: (frame - size + 1, episode, size)."""
    return np.lib.stride_tricks.sliding_window_view(frames, size, axis=0)


def _next(event: Bool[np.ndarray, "frame episode"]) -> Int[np.ndarray, "next episode"]:
    """Return, for each frame, the first frame with the event from there on; a number beyond all frames if none."""
    frames, episodes = event.shape
    where = np.full((frames + 1, episodes), np.iinfo(np.int32).max, np.int32)
    where[:-1] = np.where(event, np.arange(frames, dtype=np.int32)[:, None], where[:-1])
    return np.minimum.accumulate(where[::-1], axis=0)[::-1]
