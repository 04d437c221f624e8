"""The events of a street, each defined once: rewards, terminations and metrics all read these.

Every function is plain arithmetic that broadcasts: it serves JAX arrays in the simulator and NumPy arrays in metrics.
"""

from __future__ import annotations

import equinox as eqx
from jaxtyping import Array, Bool

from jaxwalk.sim.geometry import to_frame

ENCOUNTER_DISTANCE = 20.0
"""An encounter begins only with the car within this distance [m]."""
CLOSING_SPEED = 0.1
"""An encounter begins only while the car closes in faster than this [m/s]."""
BRAKING = -1.0
"""A car brakes if its commanded acceleration is at or below this [m/s2]."""
BRAKING_HOLD = 0.3
"""Braking counts once it has been held this long [s]."""
BRAKING_MIN_SPEED = 1.0
"""Braking counts only for a car faster than this [m/s]."""


class Events(eqx.Module):
    """What ended an episode, if anything did. In one step a collision wins over the goal, the goal over a timeout."""

    collision: Bool[Array, "*batch"]
    goal: Bool[Array, "*batch"]
    timeout: Bool[Array, "*batch"]
    touched: Bool[Array, "ped *batch"]
    """The pedestrians that the car touched, by the contact that ends episodes."""


def distance(dx, dy):
    """Return the Euclidean distance of a displacement [m]."""
    return (dx * dx + dy * dy) ** 0.5


def closing_speed(dx, dy, dvx, dvy):
    """Return how fast two centres approach each other [m/s], from their relative position and velocity."""
    return -(dx * dvx + dy * dvy) / (distance(dx, dy) + 1e-9)


def closes_in(dx, dy, dvx, dvy):
    """Return whether a pedestrian on a roadway begins an encounter: the car is near and comes closer."""
    return (distance(dx, dy) <= ENCOUNTER_DISTANCE) & (closing_speed(dx, dy, dvx, dvy) > CLOSING_SPEED)


def touches(dx, dy, collision_distance):
    """Return whether car and pedestrian collide: centres closer than this [m] (the paper's criterion)."""
    return dx * dx + dy * dy < collision_distance**2


def to_rectangle(ahead, left, length, width):
    """Return the distance from a point in the car's frame to the car's rectangle [m]; 0 inside it.

    A body about the point touches the car where this is below the body's radius.
    """
    return distance(_above_zero(abs(ahead) - length / 2), _above_zero(abs(left) - width / 2))


def touching(rules, dx, dy, cos, sin):
    """Return whether car and pedestrian collide, by the contact that ends episodes.

    Args:
        rules: `SimConfig` or `jaxwalk.sim.world.Rules`.
        dx: displacement from the car's centre to the pedestrian's along x [m].
        dy: displacement along y [m].
        cos: cosine of the car's heading in the same axes.
        sin: sine of it.
    """
    if rules.contact == "disc":
        return touches(dx, dy, rules.collision_distance)
    return to_rectangle(*to_frame(dx, dy, cos, sin), rules.car_length, rules.car_width) < rules.body_radius


def contact_gap(rules, dx, dy, cos, sin):
    """Return how much is missing until car and pedestrian collide [m]; below 0 where they do. Arguments: `touching`."""
    if rules.contact == "disc":
        return distance(dx, dy) - rules.collision_distance
    return to_rectangle(*to_frame(dx, dy, cos, sin), rules.car_length, rules.car_width) - rules.body_radius


def _above_zero(x):
    """Return x, or 0 if it is negative."""
    return (x + abs(x)) / 2


def arrives(dx, dy, goal_distance):
    """Return whether the car is within ``goal_distance`` [m] of its goal."""
    return dx * dx + dy * dy <= goal_distance**2
