"""Pedestrians of an OpenSCENARIO document as people of a scripted test."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.crash_suite import LONGEST
from jaxwalk.scenarios.xosc.catalog_entries import CatalogEntries
from jaxwalk.scenarios.xosc.changing_speeds import Change, change_of, check_times, thinned, timed_path, walked
from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, number, only, part, word
from jaxwalk.scenarios.xosc.meeting_people import MEETS, meeting_plan
from jaxwalk.scenarios.xosc.positions import Positions, points_of
from jaxwalk.scenarios.xosc.road_users import DRIVING, Happening, RoadUser, private_actions
from jaxwalk.scenarios.xosc.trajectories import vertices
from jaxwalk.scenarios.xosc.triggers import Beginning, Comes, Triggers

OFF_PATH = 2.0
"""Who follows a trajectory begins at most so far from its first point [m]."""
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


@dataclass
class PedestrianReader:
    """Reads what pedestrians do."""

    positions: Positions
    catalogs: CatalogEntries
    triggers: Triggers
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
        steps = [one for one in first if one.action.tag != "TeleportAction"]
        later = [step for event in user.events for step in self._steps(event, user)]
        way, timing = self._way(user, [*steps, *later])
        speeds = [one for one in (*steps, *later) if one.action.tag == "LongitudinalAction"]
        changes = [change_of(one.action, one.begins, one.names) for one in speeds]
        meets = [one for one in later if one.action.tag == "SynchronizeAction"]
        if meets:
            return self._meeting(way, meets, changes)
        if timing is not None:
            return self._timed(way, timing, changes)
        return self._at_speeds(way, changes)

    def _steps(self, event: Happening, user: RoadUser) -> list[WalkerAction]:
        """Return what an event does to a pedestrian; nothing of what follows a contact."""
        actions = [one for one in private_actions(event.element) if one.tag in DRIVING]
        for one in event.element.findall("Action"):
            if one.find("PrivateAction") is None or not actions:
                self.notes.append(f"{called(event.element)} of {user.name}: its action isn't played")
        if not actions:
            return []
        begins = self.triggers.moment(event.element, user.name)
        if begins.comes == Comes.CONTACT or (begins.comes == Comes.AFTER and begins.after in self.never):
            self.never |= event.names
            self.notes.append(f"{called(event.element)} of {user.name}: a test ends at the contact")
            return []
        begins = self.triggers.both(self.triggers.moment(event.act, user.name), begins, event.element)
        for one in actions:
            if one.tag not in ("LongitudinalAction", "RoutingAction", "SynchronizeAction"):
                raise XoscRefusal(f"{called(event.element)}: {one.tag} isn't supported; write a FollowTrajectoryAction")
        return [WalkerAction(one, begins, frozenset(event.names)) for one in actions]

    def _way(self, user: RoadUser, steps: list[WalkerAction]) -> tuple[np.ndarray, WalkerAction | None]:
        """Return the way of a pedestrian, and the step that follows a trajectory with times if there is one."""
        ways = [one for one in steps if one.action.tag == "RoutingAction"]
        if not ways:
            begin = self.positions.begin(user.name)
            return np.array([begin[:2], begin.beside(STRAIGHT_ON, 0.0)[:2]]), None
        if len(ways) > 1:
            raise XoscRefusal("RoutingAction: follows several ways one after the other; write one trajectory")
        kind = only(ways[0].action)
        if kind.tag == "FollowTrajectoryAction":
            return self._trajectory(user, kind), ways[0] if kind.find("TimeReference/Timing") is not None else None
        begin = np.array([self.positions.begin(user.name)[:2]])
        if kind.tag == "AcquirePositionAction":
            return np.concatenate([begin, points_of(self.positions, [kind])]), None
        if kind.tag == "AssignRouteAction":
            route = self.catalogs.resolved(only(kind))
            points = points_of(self.positions, route.findall("Waypoint"))
            return np.concatenate([begin, points]) if np.abs(points[:1] - begin).max() > 0.01 else points, None
        raise XoscRefusal(f"{kind.tag}: isn't supported; write a FollowTrajectoryAction")

    def _trajectory(self, user: RoadUser, action: ET.Element) -> np.ndarray:
        points = points_of(self.positions, vertices(action, self.catalogs))
        if user.name in self.positions.begins:
            begin = self.positions.begin(user.name)
            away = float(np.hypot(*(points[0] - begin[:2])))
            if away > OFF_PATH:
                raise XoscRefusal(
                    f"Trajectory: begins {away:.1f} m from where the pedestrian begins; correct one of them"
                )
        return points

    def _meeting(self, way: np.ndarray, steps: list[WalkerAction], changes: list[Change]) -> Walker:
        """Return who is at a place when the unbraked car is at another; a car that brakes meets them all the same."""
        if len(steps) > 1 or any(one.target > 0 for one in changes) or steps[0].begins.comes != Comes.AT_ONCE:
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
        if any(one.target > 0 for one in changes):
            raise XoscRefusal("SpeedAction: the times of the trajectory say the speed; leave one of them out")
        action = only(step.action)
        timing = part(action, "TimeReference/Timing")
        times = np.array([number(one, "time") for one in vertices(action, self.catalogs)])
        times = times * number(timing, "scale", 1.0) + number(timing, "offset", 0.0)
        waits = step.begins
        check_times(times)
        if word(timing, "domainAbsoluteRelative") == "absolute":
            if waits.comes not in (Comes.AT_ONCE, Comes.TIME):
                raise XoscRefusal("Timing: absolute times can't wait for the car; write relative ones")
            begun = waits.value
            waits = Beginning(Comes.AT_ONCE)
            if begun > times[0]:
                raise XoscRefusal("Timing: the trajectory begins before its event; write relative times")
        elif waits.delay:
            times, waits = times + waits.delay, waits._replace(delay=0.0)
        return _walking(way, times, waits)

    def _at_speeds(self, way: np.ndarray, changes: list[Change]) -> Walker:
        """Return who walks at speeds that actions say."""
        waits = _first(changes)
        if all(one.target == 0 for one in changes):
            return Walker(way[:1], np.zeros(0), Beginning(Comes.AT_ONCE))
        if waits.comes in (Comes.AFTER, Comes.OWN_WAY, Comes.CONTACT):
            raise XoscRefusal(
                f"SpeedAction: waits for {waits.comes}, but nothing comes before; wait for the car or a time"
            )
        origin = waits.value if waits.comes == Comes.TIME else 0.0
        shifted = [_since(change, waits, origin) for change in changes if change.target > 0 or change.begins != waits]
        points, times = timed_path(way, walked(shifted, LONGEST))
        return _walking(points, times, waits._replace(delay=0.0))


def _first(changes: list[Change]) -> Beginning:
    """Return when somebody sets out: with the first change to a speed above 0."""
    return next((one.begins for one in changes if one.target > 0), Beginning(Comes.AT_ONCE))


def _since(change: Change, waits: Beginning, origin: float) -> Change:
    """Return a change whose moment counts from setting out. Raise XoscRefusal if it depends on the car once more."""
    moment = change.begins
    if moment == waits:
        return change._replace(begins=Beginning(Comes.TIME, 0.0, delay=waits.delay))
    timed = waits.comes in (Comes.TIME, Comes.AT_ONCE) and moment.comes in (Comes.TIME, Comes.AT_ONCE)
    if timed and moment.value >= origin:
        return change._replace(begins=Beginning(Comes.TIME, moment.value - origin))
    if moment.comes in (Comes.AFTER, Comes.OWN_WAY):
        return change
    raise XoscRefusal(f"SpeedAction: waits for {moment.comes} after the person has set out; a person waits once")


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
