"""The events of a street, each defined once: rewards, terminations and metrics all read these.

Every function is plain arithmetic that broadcasts: it serves JAX arrays in the simulator and NumPy arrays in metrics.
"""

from __future__ import annotations

ENCOUNTER_DISTANCE = 20.0
"""An encounter needs the car within this distance [m] ..."""
CLOSING_SPEED = 0.1
"""... and closing faster than this [m/s]."""
BRAKING = -1.0
"""A commanded acceleration at or below this is braking [m/s2] ..."""
BRAKING_HOLD = 0.3
"""... once it is held this long [s] ..."""
BRAKING_MIN_SPEED = 1.0
"""... by a car faster than this [m/s]."""


def distance(dx, dy):
    """Euclidean distance of a displacement [m]."""
    return (dx * dx + dy * dy) ** 0.5


def closing_speed(dx, dy, dvx, dvy):
    """How fast two centres approach each other [m/s]: minus d/dt of their distance; both vectors are relative."""
    return -(dx * dvx + dy * dvy) / (distance(dx, dy) + 1e-9)


def closes_in(dx, dy, dvx, dvy):
    """Whether a pedestrian on a roadway begins an encounter: the car within 20 m and closing at more than 0.1 m/s."""
    return (distance(dx, dy) <= ENCOUNTER_DISTANCE) & (closing_speed(dx, dy, dvx, dvy) > CLOSING_SPEED)


def touches(dx, dy, collision_distance):
    """Whether car and pedestrian collide: centres closer than ``collision_distance`` [m] (the paper's criterion)."""
    return dx * dx + dy * dy < collision_distance**2


def arrives(dx, dy, goal_distance):
    """Whether the car is within ``goal_distance`` [m] of its goal."""
    return dx * dx + dy * dy <= goal_distance**2
