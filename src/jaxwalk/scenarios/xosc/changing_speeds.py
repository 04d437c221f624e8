"""Walks at speeds that change: where somebody is when, from what changes their speed."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.xosc.elements import XoscRefusal, number, only, part, word
from jaxwalk.scenarios.xosc.triggers import Beginning, Comes

FINE = 0.1
"""Time between the points of a walk whose speed changes [s]."""
APART = 1e-6
"""Times and places nearer than this are one [s, m]."""


class Change(NamedTuple):
    """A change of speed, or the beginning of a way."""

    begins: Beginning
    target: float | None
    """The speed after it [m/s]; None where a way begins, on which the speed stays what it is."""
    dimension: str = "time"
    """What ``value`` is: ``time``, ``rate`` or ``distance``; of a sudden change, ``time`` with 0."""
    value: float = 0.0
    names: frozenset[str] = frozenset()
    """The names of its event and action."""

    @property
    def moves(self) -> bool:
        """Return whether somebody walks after it."""
        return self.target is not None and self.target > 0

    def lasts(self, speed: float) -> float:
        """Return how long the change takes from a speed [s]."""
        target = speed if self.target is None else self.target
        if self.dimension == "rate":
            return abs(target - speed) / max(abs(self.value), APART)
        if self.dimension == "distance":
            return 2 * self.value / max(target + speed, APART)
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
    shape = word(dynamics, "dynamicsShape")
    if shape == "step":
        return Change(begins, speed, names=names)
    if shape != "linear":
        raise XoscRefusal(f"SpeedActionDynamics: dynamicsShape {shape} isn't supported; write step or linear")
    if dimension not in ("time", "rate", "distance"):
        raise XoscRefusal(f"SpeedActionDynamics: dynamicsDimension {dimension} isn't supported; use time")
    return Change(begins, speed, dimension, abs(number(dynamics, "value")), names)


def walked(changes: list[Change], longest: float) -> np.ndarray:
    """Return the ways after times of somebody who first stands, float64 (point, 2): [s], [m].

    Changes come in the order of their times; a later one ends an earlier one that isn't over yet. ``longest`` is how
    long they walk on at most [s]. Raise XoscRefusal if a change never comes.
    """
    ways = {name for one in changes if one.target is None for name in one.names}
    walk, pending = _Walk(longest), list(changes)
    while pending:
        times = [walk.comes(one, {*ways, *_names(pending)}) for one in pending]
        first = int(np.argmin(times))  # the first in the file of those that come together
        if times[first] == np.inf:
            _check_ends(pending, ways)
            break
        if times[first] > longest:
            break
        walk.goes_on(times[first])
        walk.begins(pending.pop(first))
    walk.goes_on(longest)
    return np.array(walk.knots)


def _names(changes: list[Change]) -> set[str]:
    return {name for one in changes for name in one.names}


def _check_ends(never: list[Change], ways: set[str]) -> None:
    """Raise XoscRefusal if changes that never come aren't stops at the end of a way, where people stand anyway."""
    for change in never:
        moment = change.begins
        if moment.comes == Comes.OWN_WAY:
            raise XoscRefusal(f"TraveledDistanceCondition: the person never walks {moment.value:g} m; correct it")
        if moment.after not in ways or moment.started:
            raise XoscRefusal(
                f"StoryboardElementStateCondition: {moment.after!r} isn't an earlier event of the same person"
            )
        if change.moves:
            raise XoscRefusal(
                f"StoryboardElementStateCondition: people stand at the end of their way, so that nothing comes after "
                f"{moment.after!r}; write one way"
            )


class _Walk:
    """Somebody on their way: how far they have come, how fast they are, and what has begun and is over."""

    def __init__(self, longest: float) -> None:
        self.longest = longest
        self.knots, self.speed = [(0.0, 0.0)], 0.0
        self.target, self.until = 0.0, 0.0
        self.running: frozenset[str] = frozenset()
        self.over: dict[str, float] = {}
        self.begun: dict[str, float] = {}

    def comes(self, change: Change, unfinished: set[str]) -> float:
        """Return when a change comes if nothing else does before [s]; inf if that isn't known, or never.

        ``unfinished`` are names of what isn't over when the present change of speed is.
        """
        now, moment = self.knots[-1][0], change.begins
        if moment.comes == Comes.OWN_WAY:
            return max(now, self._when_at(moment.value) + moment.delay)
        if moment.comes != Comes.AFTER:
            return max(now, moment.value + moment.delay)
        if moment.started:
            return max(now, self.begun.get(moment.after, np.inf) + moment.delay)
        if moment.after in unfinished:
            return np.inf
        ends = self.until if moment.after in self.running else self.over.get(moment.after, np.inf)
        return max(now, ends + moment.delay)

    def begins(self, change: Change) -> None:
        """Begin a change now. Raise XoscRefusal if it is a way that begins under way."""
        now, way = self.knots[-1]
        for name in change.names:
            self.begun.setdefault(name, now)
        if change.target is None:
            if way > APART:
                raise XoscRefusal(f"RoutingAction: begins when the person has walked {way:.1f} m; write one trajectory")
            return
        self._ends(now)
        self.target, self.until, self.running = change.target, now + change.lasts(self.speed), change.names
        if self.until <= now + APART:
            self.speed = self.target
            self._ends(now)

    def goes_on(self, to: float) -> None:
        """Walk on until a time [s]."""
        now, way = self.knots[-1]
        end = min(to, self.until)
        if end > now + APART:
            rate = (self.target - self.speed) / (self.until - now)
            for after in np.linspace(0, end - now, int(np.ceil((end - now) / FINE)) + 1)[1:].tolist():
                self.knots.append((now + after, way + after * (self.speed + rate * after / 2)))
            self.speed = self.target if end >= self.until - APART else self.speed + rate * (end - now)
        if self.until <= to:
            self._ends(self.until)
        now, way = self.knots[-1]
        if to > now + APART:
            self.knots.append((to, way + self.speed * (to - now)))

    def _ends(self, now: float) -> None:
        """Note that the change that was running is over, or ended by another one."""
        for name in self.running:
            self.over[name] = max(now, self.over.get(name, now))
        self.running, self.until = frozenset(), min(self.until, now)

    def _when_at(self, metres: float) -> float:
        """Return when the person has walked so far, as things are now [s]; inf if never."""
        times, ways = np.array(self.knots).T
        if metres <= ways[-1]:
            return float(times[np.argmax(ways >= metres)] if metres <= 0 else np.interp(metres, *_rising(ways, times)))
        ahead = _Walk(self.longest)
        ahead.knots, ahead.speed, ahead.target, ahead.until = self.knots[-1:], self.speed, self.target, self.until
        ahead.goes_on(self.longest)
        times, ways = np.array(ahead.knots).T
        return float(np.interp(metres, *_rising(ways, times))) if metres <= ways[-1] else np.inf


def _rising(ways: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return ways and times without the times at which somebody has come no farther."""
    farther = np.concatenate([[True], np.diff(np.maximum.accumulate(ways)) > 0])
    return ways[farther], times[farther]


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
