"""Where an episode stands. Positions in metres; arrays end in the batch axes."""

from __future__ import annotations

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int


class VehicleState(eqx.Module):
    """The car, about its centre."""

    x: Float[Array, "*batch"]
    """[m]"""
    y: Float[Array, "*batch"]
    """[m]"""
    cos: Float[Array, "*batch"]
    """Heading, as its cosine and sine: nothing in a step needs the angle."""
    sin: Float[Array, "*batch"]
    speed: Float[Array, "*batch"]
    """[m/s], never negative."""
    steering: Float[Array, "*batch"]
    """Angle commanded in the last step [rad], positive to the left."""
    acceleration: Float[Array, "*batch"]
    """Commanded in the last step [m/s2]."""
    along: Float[Array, "*batch"]
    """How far it has come along its lane route [m]."""


class PedestrianState(eqx.Module):
    """The pedestrians. A committed path is a chain of straight legs; a position is a leg and what remains of it."""

    end_x: Float[Array, "ped *batch"]
    """Where the current leg ends [m]."""
    end_y: Float[Array, "ped *batch"]
    cos: Float[Array, "ped *batch"]
    """Direction of the leg, a unit vector (0, 0 before the first leg)."""
    sin: Float[Array, "ped *batch"]
    remaining: Float[Array, "ped *batch"]
    """Metres left of the leg."""
    leg: Int[Array, "ped *batch"]
    """What the leg is: SIDEWALK, ON_CROSSWALK, TO_ZONE or ACROSS."""
    node: Int[Array, "ped *batch"]
    """The waypoint where the leg ends; for TO_ZONE and ACROSS, the first one after the jaywalk."""
    landing_x: Float[Array, "ped *batch"]
    """Where a committed jaywalk will end [m]."""
    landing_y: Float[Array, "ped *batch"]
    to_kerb: Float[Array, "ped *batch"]
    """Metres of committed path until it enters a roadway; inf where it doesn't, negative once it has."""
    crossing: Int[Array, "ped *batch"]
    """NO_CROSSING, CROSSWALK or JAYWALK: what was decided about the next or current crossing."""
    decisions: Int[Array, "ped *batch"]
    """Crossings decided about so far."""
    goal: Int[Array, "ped *batch"]
    """The waypoint walked to."""
    arrivals: Int[Array, "ped *batch"]
    """Goals reached so far."""
    going: Bool[Array, "ped *batch"]
    """Whether it walked in the last step."""
    on_roadway: Bool[Array, "ped *batch"]
    """Between the kerbs."""
    on_crosswalk: Bool[Array, "ped *batch"]
    """Inside a crosswalk's rectangle."""

    @property
    def x(self) -> Float[Array, "ped *batch"]:
        """Position [m]."""
        return self.end_x - self.cos * self.remaining

    @property
    def y(self) -> Float[Array, "ped *batch"]:
        """Position [m]."""
        return self.end_y - self.sin * self.remaining


class State(eqx.Module):
    """One moment of an episode."""

    step: Int[Array, "*batch"]
    """Steps since the start."""
    vehicle: VehicleState
    pedestrian: PedestrianState
