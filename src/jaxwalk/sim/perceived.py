"""What the car has perceived of people, as the state keeps it. Arrays end in the batch axes."""

from __future__ import annotations

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int

KEPT = 3.0
"""Who is lost from sight is remembered for this long [s]."""


class Sighting(eqx.Module):
    """How the car's sensors see people at one moment."""

    seen: Bool[Array, "ped *batch"]
    """Whether the car sees them; everything else is 0 where it doesn't."""
    x: Float[Array, "ped *batch"]
    """Position [m]."""
    y: Float[Array, "ped *batch"]
    velocity_x: Float[Array, "ped *batch"]
    """Velocity [m/s]."""
    velocity_y: Float[Array, "ped *batch"]
    on_roadway: Bool[Array, "ped *batch"]
    """Whether they are between the kerbs."""
    crossing: Int[Array, "ped *batch"]
    """The `jaxwalk.sim.crossing_kind.CrossingKind` of the crossing that they are on; of nothing off the roadway."""
    decisions: Int[Array, "ped *batch"]
    """How many crossings they had decided about: it tells one crossing from the next. 0 where nobody may jaywalk."""


class CrossingsSeen(eqx.Module):
    """The crossings of each person that the car has seen so far."""

    jaywalks: Int[Array, "ped *batch"]
    crosswalks: Int[Array, "ped *batch"]
    last: Int[Array, "ped *batch"]
    """The ``decisions`` of the last one, so that a crossing counts once."""


class Perceived(eqx.Module):
    """What the car knows of people. Who is in sight sees the car, whatever its sensors miss."""

    in_sight: Bool[Array, "ped *batch"]
    """Whether the straight line between the car's front axle and the person is free, and within the range of sight."""
    now: Sighting
    """What reaches the driver at this moment: with a delay, how it was then."""
    last: Sighting
    """How each person was last perceived; ``seen`` says whether that is at most `KEPT` ago."""
    age: Float[Array, "ped *batch"]
    """How old that is [s]; grows on after `KEPT`."""
    crossings: CrossingsSeen
    on_the_way: Sighting | None
    """What doesn't reach the driver yet, the oldest first: each array has an axis of steps before ``ped``. None without
    a delay."""
