"""Walks at speeds that change: where somebody is when, from what changes their speed."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.xosc.elements import XoscRefusal, number, only, part, word
from jaxwalk.scenarios.xosc.triggers import Beginning, Comes

FINE = 0.1
"""Time between the points of a walk whose speed changes [s]."""
APART = 1e-6
"""Times and places nearer than this are one [s, m]."""


class Change(NamedTuple):
    """A change of speed."""

    begins: Beginning
    target: float
    """The speed after it [m/s]."""
    dimension: str
    """What ``value`` is: ``time``, ``rate`` or ``distance``; of a sudden change, ``time`` with 0."""
    value: float
    names: frozenset[str] = frozenset()
    """The names of its event and action."""

    def lasts(self, speed: float) -> float:
        """Return how long the change takes from a speed [s]."""
        if self.dimension == "rate":
            return abs(self.target - speed) / max(abs(self.value), APART)
        if self.dimension == "distance":
            return 2 * self.value / max(self.target + speed, APART)
        return self.value


def change_of(action: ET.Element, begins: Beginning, names: frozenset[str] = frozenset()) -> Change:
    """Return what a ``LongitudinalAction`` changes. Raise XoscRefusal if it says no speed."""
    kind = only(action)
    if kind.tag != "SpeedAction":
        raise XoscRefusal(f"{kind.tag}: isn't supported; write a SpeedAction")
    target, dynamics = only(part(kind, "SpeedActionTarget")), part(kind, "SpeedActionDynamics")
    if target.tag != "AbsoluteTargetSpeed":
        raise XoscRefusal(f"{target.tag}: isn't supported; write an AbsoluteTargetSpeed")
    speed, dimension = number(target, "value"), word(dynamics, "dynamicsDimension")
    if speed < 0:
        raise XoscRefusal("AbsoluteTargetSpeed: below 0; turn the entity round")
    if word(dynamics, "dynamicsShape") == "step":
        return Change(begins, speed, "time", 0.0, names)
    if dimension not in ("time", "rate", "distance"):
        raise XoscRefusal(f"SpeedActionDynamics: dynamicsDimension {dimension} isn't supported; use time")
    return Change(begins, speed, dimension, abs(number(dynamics, "value")), names)


def walked(changes: list[Change], longest: float) -> np.ndarray:
    """Return the ways after times of somebody who first stands, float64 (point, 2): [s], [m].

    ``longest`` is how long they walk on at most [s]. Raise XoscRefusal if a change never comes.
    """
    knots, speed, over, begun = [(0.0, 0.0)], 0.0, {}, {}
    for change in changes:
        time, way = knots[-1]
        comes = _when(change, knots[-1], speed, (over, begun))
        if comes > time + APART:
            knots.append((comes, way + speed * (comes - time)))
        time, way = knots[-1]
        lasts = change.lasts(speed)
        for share in np.linspace(0, 1, max(2, int(np.ceil(lasts / FINE)) + 1))[1:] if lasts > APART else ():
            gathered = speed + share * (change.target - speed) / 2
            knots.append((time + share * lasts, way + gathered * share * lasts))
        speed = change.target
        begun |= dict.fromkeys(change.names, time)
        over |= dict.fromkeys(change.names, knots[-1][0])
    time, way = knots[-1]
    knots.append((max(time, longest), way + speed * max(0.0, longest - time)))
    return np.array(knots)


def _when(
    change: Change, now: tuple[float, float], speed: float, known: tuple[dict[str, float], dict[str, float]]
) -> float:
    """Return when a change comes [s after setting out]; ``known`` says when earlier ones were over and had begun."""
    (time, way), moment = now, change.begins
    if moment.comes == Comes.AFTER:
        times = known[moment.started]
        if moment.after not in times:
            raise XoscRefusal(
                f"StoryboardElementStateCondition: {moment.after!r} isn't an earlier event of the same person"
            )
        return max(time, times[moment.after] + moment.delay)
    if moment.comes == Comes.OWN_WAY:
        if speed <= 0 and moment.value > way:
            raise XoscRefusal(f"TraveledDistanceCondition: the person never walks {moment.value:g} m; correct it")
        return max(time, time + (moment.value - way) / max(speed, APART)) + moment.delay
    return max(time, moment.value + moment.delay)


def timed_path(way: np.ndarray, knots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (point, 2) [m] and times (point,) [s] of a walk along a way, to its end or as long as it lasts.

    Args:
        way: the corners of the way, float64 (corner, 2) [m].
        knots: how far somebody has come after some times, float64 (knot, 2): [s], [m].
    """
    along = np.concatenate([[0.0], np.hypot(*np.diff(way, axis=0).T).cumsum()])
    times, ways = knots.T
    stops = ways >= along[-1] - APART
    moving = np.maximum.accumulate(ways) + np.arange(len(ways)) * 1e-12  # so that each place has one time
    corners = np.interp(along[along <= ways[-1] + APART], moving, times)
    end = corners[-1] if stops.any() else times[-1]
    every = np.unique(np.concatenate([times[times < end], corners, [end]]))
    every = every[np.concatenate([[True], np.diff(every) > APART])]
    at = np.minimum(np.interp(every, times, ways), along[-1])
    return np.stack([np.interp(at, along, way[:, k]) for k in (0, 1)], axis=1), every


def thinned(points: np.ndarray, times: np.ndarray, within: float = 1e-3) -> tuple[np.ndarray, np.ndarray]:
    """Return a timed path with only the points that are needed to be within some metres of it at all times."""
    kept, first = [0], 0
    for last in range(2, len(times)):
        inner = np.arange(first + 1, last)
        share = (times[inner] - times[first]) / (times[last] - times[first])
        straight = points[first] + share[:, None] * (points[last] - points[first])
        if np.abs(straight - points[inner]).max() > within:
            first = last - 1
            kept.append(first)
    kept.append(len(times) - 1)
    return points[kept], times[kept]


def check_times(times: np.ndarray) -> None:
    """Raise XoscRefusal if the times of a trajectory don't rise."""
    if any(late <= early for early, late in pairwise(times.tolist())):
        raise XoscRefusal("Polyline: the times of its vertices don't rise; correct them, or write TimeReference None")
