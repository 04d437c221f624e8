"""The state of an episode. Positions are in metres; arrays end in the batch axes."""

from __future__ import annotations

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.sim.perceived import Perceived


class Course(eqx.Module):
    """The car's route at the point nearest to the car, in the map's axes."""

    x: Float[Array, "*batch"]
    """Position of that point [m]."""
    y: Float[Array, "*batch"]
    cos: Float[Array, "*batch"]
    """Direction of travel there, a unit vector."""
    sin: Float[Array, "*batch"]
    limit: Float[Array, "*batch"]
    """The speed limit there [m/s]."""
    ahead_x: Float[Array, "point *batch"]
    """Points of the route ahead [m] (`jaxwalk.sim.map_tables.POINTS`)."""
    ahead_y: Float[Array, "point *batch"]


class VehicleState(eqx.Module):
    """The car, about its centre."""

    x: Float[Array, "*batch"]
    """Position of the centre [m]."""
    y: Float[Array, "*batch"]
    """Position of the centre [m]."""
    cos: Float[Array, "*batch"]
    """Heading, as its cosine and sine: nothing in a step needs the angle."""
    sin: Float[Array, "*batch"]
    speed: Float[Array, "*batch"]
    """Speed [m/s], never negative."""
    steering: Float[Array, "*batch"]
    """Angle commanded in the last step [rad], positive to the left."""
    acceleration: Float[Array, "*batch"]
    """Acceleration commanded in the last step [m/s2]."""
    along: Float[Array, "*batch"]
    """Distance travelled along its lane route [m]."""
    course: Course
    """Its route there."""


class Leg(eqx.Module):
    """A straight piece of a committed path, and all that changes only from one leg to the next."""

    end_x: Float[Array, "ped *batch"]
    """Where it ends [m]."""
    end_y: Float[Array, "ped *batch"]
    cos: Float[Array, "ped *batch"]
    """Its direction, a unit vector (0, 0 for the leg that only stands for the start)."""
    sin: Float[Array, "ped *batch"]
    length: Float[Array, "ped *batch"]
    """Length of the leg [m]."""
    kind: Int[Array, "ped *batch"]
    """A `jaxwalk.sim.crossing_kind.LegKind`."""
    node: Int[Array, "ped *batch"]
    """The node where it ends; for the way over the roadway of a jaywalk, the first one after it."""
    side: Int[Array, "ped *batch"]
    """The side of the crossing that was decided about last."""
    begin: Float[Array, "ped *batch"]
    """Where in that side's zone a jaywalk begins, in pieces of the zone's line; below 0 without a zone."""
    road_end: Float[Array, "ped *batch"]
    """Metres before its end at which a leg over a roadway leaves it; negative if it ends on the roadway."""
    kerb_past_end: Float[Array, "ped *batch"]
    """Metres from its end to where the committed path enters a roadway: negative if before the end, inf if nowhere."""
    crossing: Int[Array, "ped *batch"]
    """The `jaxwalk.sim.crossing_kind.CrossingKind` decided for the next or current crossing."""
    decisions: Int[Array, "ped *batch"]
    """Crossings decided about so far, but for those without a zone, where nobody has a choice."""
    goal: Int[Array, "ped *batch"]
    """The waypoint walked to."""
    arrivals: Int[Array, "ped *batch"]
    """Goals reached so far."""


class PedestrianState(eqx.Module):
    """The pedestrians. A position is given by a leg and the metres left of it."""

    leg: Leg
    """The current leg."""
    following: Leg
    """The next leg, where ``planned``."""
    planned: Bool[Array, "ped *batch"]
    """Whether ``following`` is known already. This saves time only; it never changes where anybody walks."""
    remaining: Float[Array, "ped *batch"]
    """Metres left of the leg."""
    going: Bool[Array, "ped *batch"]
    """Whether it walked in the last step; at the start, True but for scripted people who wait."""
    on_roadway: Bool[Array, "ped *batch"]
    """Whether it is between the kerbs."""
    on_crosswalk: Bool[Array, "ped *batch"]
    """Whether it is between the kerbs on a crosswalk."""
    since: Float[Array, "ped *batch"] | None = None
    """For how long a scripted person has walked [s], negative before it sets out; None where nobody is scripted."""

    @property
    def x(self) -> Float[Array, "ped *batch"]:
        """Position [m]."""
        return self.leg.end_x - self.leg.cos * self.remaining

    @property
    def y(self) -> Float[Array, "ped *batch"]:
        """Position [m]."""
        return self.leg.end_y - self.leg.sin * self.remaining

    @property
    def to_kerb(self) -> Float[Array, "ped *batch"]:
        """Metres of committed path until it enters a roadway; inf where it doesn't, negative once it has."""
        return self.leg.kerb_past_end + self.remaining

    @property
    def crossing(self) -> Int[Array, "ped *batch"]:
        """What was decided about the next or current crossing."""
        return self.leg.crossing

    @property
    def may_jaywalk(self) -> Bool[Array, "ped *batch"]:
        """Whether people may jaywalk at the crossing that was decided about last: else to use it was no choice."""
        return self.leg.begin >= 0

    @property
    def decisions(self) -> Int[Array, "ped *batch"]:
        """Crossings decided about so far."""
        return self.leg.decisions

    @property
    def goal(self) -> Int[Array, "ped *batch"]:
        """The waypoint walked to."""
        return self.leg.goal

    @property
    def arrivals(self) -> Int[Array, "ped *batch"]:
        """Goals reached so far."""
        return self.leg.arrivals


class Motion(eqx.Module):
    """People in the car's frame."""

    ahead: Float[Array, "_ *batch"]
    """Distance ahead of the car [m]; negative behind it."""
    left: Float[Array, "_ *batch"]
    """Distance to the left of the car [m]; negative to the right."""
    ahead_speed: Float[Array, "_ *batch"]
    """Velocity over ground in the direction of the car's heading [m/s]."""
    left_speed: Float[Array, "_ *batch"]
    """Velocity over ground to the left of the car's heading [m/s]."""

    def at(self, time: Array) -> tuple[Array, Array]:
        """Return ``ahead`` and ``left`` of people who keep their velocity after some time [s]."""
        return self.ahead + self.ahead_speed * time, self.left + self.left_speed * time


class Foresight(eqx.Module):
    """What the car sees and what lies ahead of it (`jaxwalk.sim.prediction`): reused and expensive, so kept.

    All of it is as perceived. People that the car doesn't perceive are `jaxwalk.sim.prediction.AWAY`.
    """

    people: Motion
    """Everybody; arrays ``(ped, *batch)``."""
    nearest: Motion
    """The `NEIGHBOURS` nearest people, nearest first; arrays ``(neighbour, *batch)``."""

    route_x: Float[Array, "point *batch"]
    """Distances ahead of the car of the points of the route ahead [m]."""
    route_y: Float[Array, "point *batch"]
    """Distances to the left of the car of the same points [m]."""
    clearance: Float[Array, "manoeuvre *batch"]
    """Smallest predicted distance to anybody if the car brakes, holds its speed or accelerates [m]: between the
    centres, or from the car's rectangle to the body, as the world's contact is."""
    conflict: Float[Array, "manoeuvre *batch"]
    """Time until each manoeuvre's first conflict [s]."""
    crosswalk_user: Bool[Array, "*batch"]
    """Somebody is on a crosswalk close ahead of the car."""
    jaywalker: Bool[Array, "*batch"]
    """Somebody jaywalks on the roadway close ahead of the car."""


class State(eqx.Module):
    """One moment of an episode."""

    step: Int[Array, "*batch"]
    """Steps since the start."""
    vehicle: VehicleState
    pedestrian: PedestrianState
    foresight: Foresight
    perceived: Perceived | None = None
    """What the car knows of people; None where everybody sees everybody."""
