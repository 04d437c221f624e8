"""Pedestrians of an OpenSCENARIO document as people of a scripted test."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.crash_suite import LONGEST
from jaxwalk.scenarios.xosc.changing_speeds import Change, change_of, thinned, timed_path, walked
from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, only, part, word
from jaxwalk.scenarios.xosc.meeting_people import MEETS, meeting_plan
from jaxwalk.scenarios.xosc.positions import Positions, points_of
from jaxwalk.scenarios.xosc.road_users import DRIVING, Happening, RoadUser
from jaxwalk.scenarios.xosc.trajectories import times_of, timing_of, vertices, waypoints
from jaxwalk.scenarios.xosc.triggers import WORDS, Beginning, Comes, Triggers, check_stops

OFF_PATH = 2.0
"""Who follows a trajectory begins at most so far from its first point [m]."""
PLAYED = ("LongitudinalAction", "RoutingAction", "SynchronizeAction")
"""Actions that people do after they were put to their places."""
BY_CAR = (Comes.PLACE, Comes.ARRIVAL)
"""What the car decides."""
MOST_CHANGES = 200
"""Most changes of somebody's speed."""
STRAIGHT_ON = 200.0
"""Way of who walks straight on [m]."""


class Walker(NamedTuple):
    """Somebody's way, in the coordinates of the document."""

    points: np.ndarray
    """float64 (point, 2) [m]."""
    times: np.ndarray
    """When they are there [s after setting out]; empty for who stands."""
    waits: Beginning
    """When they set out."""


class WalkerAction(NamedTuple):
    """Something that a pedestrian does."""

    action: ET.Element
    begins: Beginning
    names: frozenset[str]
    """The names of its event and action."""


@dataclass
class PedestrianReader:
    """Reads what pedestrians do."""

    positions: Positions
    triggers: Triggers
    lasts: float
    """How long the test lasts [s]."""
    notes: list[str]
    """What isn't played, in words."""
    never: set[str] = field(default_factory=set)
    """Names of events and actions that come after a contact."""

    def walker(self, user: RoadUser) -> Walker:
        """Return what a pedestrian does. Raise XoscRefusal if a scripted person can't do it."""
        try:
            return self._walker(user)
        except XoscRefusal as error:
            raise XoscRefusal(f"{called(user.element)} as {user.name!r}: {error}") from None

    def _walker(self, user: RoadUser) -> Walker:
        first = [WalkerAction(one, Beginning(Comes.AT_ONCE), frozenset()) for one in user.first if one.tag in DRIVING]
        later = [step for event in user.events for step in self._steps(event, user)]
        steps = [*(one for one in first if one.action.tag != "TeleportAction"), *later]
        _check_played(steps, "Init")
        way, leads = self._way(user, steps)
        changes = [_change(one) for one in steps if one.action.tag != "SynchronizeAction"]
        if len(changes) > MOST_CHANGES:
            raise XoscRefusal(
                f"{len(changes)} changes of speed; write a trajectory with times, or at most {MOST_CHANGES}"
            )
        meets = [one for one in steps if one.action.tag == "SynchronizeAction"]
        if meets:
            return self._meeting(way, meets, changes)
        if leads is not None and timing_of(only(leads.action)) is not None:
            return self._timed(way, leads, changes)
        return _at_speeds(way, changes)

    def _steps(self, event: Happening, user: RoadUser) -> list[WalkerAction]:
        """Return what an event does to a pedestrian; nothing of what follows a contact."""
        actions = event.private_actions
        if not any(one.tag in DRIVING for _, one in actions):
            return []
        of_act, begins = (self.triggers.moment(one, user.name) for one in (event.act, event.element))
        if any(
            one.comes == Comes.CONTACT or (one.comes == Comes.AFTER and one.after in self.never)
            for one in (of_act, begins)
        ):
            self.never |= event.names
            self.notes.append(f"{called(event.element)} of {user.name}: a test ends at the contact")
            return []
        check_stops(event.act, self.lasts)
        begins = self.triggers.both(of_act, begins, event.element)
        own = word(event.element, "name", "")
        steps = [WalkerAction(one, begins, frozenset((own, name))) for name, one in actions if one.tag in DRIVING]
        _check_played(steps, called(event.element))
        return steps

    def _way(self, user: RoadUser, steps: list[WalkerAction]) -> tuple[np.ndarray, WalkerAction | None]:
        """Return the way of a pedestrian, and the step that follows a trajectory if there is one."""
        ways = [one for one in steps if one.action.tag == "RoutingAction"]
        if not ways:
            begin = self.positions.begin(user.name)
            return np.array([begin[:2], begin.beside(STRAIGHT_ON, 0.0)[:2]]), None
        if len(ways) > 1:
            raise XoscRefusal("RoutingAction: follows several ways one after the other; write one trajectory")
        kind = only(ways[0].action)
        if kind.tag == "FollowTrajectoryAction":
            return self._trajectory(user, kind), ways[0]
        begin = np.array([self.positions.begin(user.name)[:2]])
        if kind.tag == "AcquirePositionAction":
            return np.concatenate([begin, points_of(self.positions, [kind])]), None
        if kind.tag == "AssignRouteAction":
            points = points_of(self.positions, waypoints(kind, self.positions.catalogs))
            return np.concatenate([begin, points]) if np.abs(points[:1] - begin).max() > 0.01 else points, None
        raise XoscRefusal(f"{kind.tag}: isn't supported; write a FollowTrajectoryAction")

    def _trajectory(self, user: RoadUser, action: ET.Element) -> np.ndarray:
        points = points_of(self.positions, vertices(action, self.positions.catalogs))
        begin = self.positions.begin(user.name)
        away = float(np.hypot(*(points[0] - begin[:2])))
        if away > OFF_PATH:
            raise XoscRefusal(f"Trajectory: begins {away:.1f} m from where the pedestrian begins; correct one of them")
        return points

    def _meeting(self, way: np.ndarray, steps: list[WalkerAction], changes: list[Change]) -> Walker:
        """Return who is at a place when the unbraked car is at another; a car that brakes meets them all the same."""
        others = [one for one in changes if one.target != 0 or one.begins.comes != Comes.AT_ONCE]
        later = any(one.target is not None or one.begins.comes != Comes.AT_ONCE for one in others)
        if len(steps) > 1 or later or steps[0].begins.comes != Comes.AT_ONCE:
            raise XoscRefusal(
                "SynchronizeAction: is read only alone, from the start on; write a FollowTrajectoryAction"
            )
        meets = meeting_plan(steps[0].action, way, self.positions, self.triggers)
        self.notes.append(MEETS)
        gathers = Change(Beginning(Comes.AT_ONCE), meets.speed, "distance", meets.run_up)
        points, times = timed_path(way, walked([gathers], LONGEST))
        return _walking(points, times, meets.waits)

    def _timed(self, way: np.ndarray, step: WalkerAction, changes: list[Change]) -> Walker:
        """Return who follows a trajectory by its times."""
        for one in changes:
            at_first = one.begins.comes == Comes.AT_ONCE and not one.names
            at_end = one.begins.comes == Comes.AFTER and one.begins.after in step.names and not one.begins.started
            if one.target is not None and (one.moves or not (at_first or at_end)):
                raise XoscRefusal("SpeedAction: the times of the trajectory say the speed; leave one of them out")
        action, waits = only(step.action), step.begins
        times = times_of(vertices(action, self.positions.catalogs))
        if word(part(action, "TimeReference/Timing"), "domainAbsoluteRelative") == "absolute":
            if waits.comes not in (Comes.AT_ONCE, Comes.TIME):
                raise XoscRefusal("Timing: absolute times can't wait for the car; write relative ones")
            if waits.value > times[0]:
                raise XoscRefusal("Timing: the trajectory begins before its event; write relative times")
            waits = Beginning(Comes.AT_ONCE)
        elif waits.delay:
            times, waits = times + waits.delay, waits._replace(delay=0.0)
        if waits.comes in (Comes.AFTER, Comes.OWN_WAY):
            raise XoscRefusal(f"FollowTrajectoryAction: waits for {_words(waits)}, but nothing comes before; "
                              "wait for the car or a time")  # fmt: skip
        return _walking(way, times, waits)


def _check_played(steps: list[WalkerAction], where: str) -> None:
    for one in steps:
        if one.action.tag not in PLAYED:
            raise XoscRefusal(f"{where}: {one.action.tag} isn't supported; write a FollowTrajectoryAction")


def _change(step: WalkerAction) -> Change:
    """Return what a step changes: the speed, or the way."""
    if step.action.tag == "RoutingAction":
        return Change(step.begins, None, names=step.names)
    return change_of(step.action, step.begins, step.names)


def _words(moment: Beginning) -> str:
    """Return what somebody waits for, in words."""
    return repr(moment.after) if moment.comes == Comes.AFTER else WORDS[moment.comes]


def _at_speeds(way: np.ndarray, changes: list[Change]) -> Walker:
    """Return who walks at speeds that actions say."""
    if not any(one.moves for one in changes):
        return Walker(way[:1], np.zeros(0), Beginning(Comes.AT_ONCE))
    waits = next((one.begins for one in changes if one.moves and one.begins.comes in BY_CAR), None)
    if waits is not None:
        knots = walked([_since(one, waits) for one in changes if not _stands(one)], LONGEST)
        return _walking(*timed_path(way, knots), waits._replace(delay=0.0))
    for one in changes:
        if one.begins.comes in BY_CAR:
            raise XoscRefusal(f"SpeedAction: waits for {_words(one.begins)} after the person has set out; "
                              "a person waits once")  # fmt: skip
    knots = walked(changes, LONGEST)
    begins = float(knots[max(int(np.argmax(knots[:, 1] > 0)) - 1, 0), 0])
    after = knots[knots[:, 0] >= begins] - (begins, 0.0)
    return _walking(*timed_path(way, after), Beginning(Comes.TIME, begins) if begins > 0 else Beginning(Comes.AT_ONCE))


def _stands(change: Change) -> bool:
    """Return whether a change leaves somebody standing who stands at the start."""
    return change.begins.comes == Comes.AT_ONCE and not change.moves


def _since(change: Change, waits: Beginning) -> Change:
    """Return a change whose moment counts from setting out. Raise XoscRefusal if it waits for something else."""
    moment = change.begins
    if moment._replace(delay=0.0) == waits._replace(delay=0.0):
        return change._replace(begins=Beginning(Comes.TIME, moment.delay))
    if moment.comes in (Comes.AFTER, Comes.OWN_WAY):
        return change
    raise XoscRefusal(
        f"SpeedAction: waits for {_words(moment)}, and another one for {_words(waits)}; a person waits once"
    )


def _walking(points: np.ndarray, times: np.ndarray, waits: Beginning) -> Walker:
    """Return who walks along points; who only stands there has no times."""
    if np.abs(points - points[0]).max() < 1e-6:
        return Walker(points[:1], np.zeros(0), Beginning(Comes.AT_ONCE))
    if times[0] < -1e-9:
        raise XoscRefusal("Polyline: begins before the time 0; correct its times")
    if times[0] > 1e-9:
        points, times = np.concatenate([points[:1], points]), np.concatenate([[0.0], times])
    points, times = thinned(points, times)
    return Walker(points, times - times[0], waits)
