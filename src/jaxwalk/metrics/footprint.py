"""When and where a car's rectangle and a pedestrian's body touch, if both keep their velocities.

Positions are those of the pedestrian's centre in the car's frame: ahead of the car's centre
and to the left [m]; velocities are relative to the car [m/s].
"""

from __future__ import annotations

from itertools import product

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.crossings import real_frames, rows_of
from jaxwalk.sim.events import to_rectangle
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory

Column = Float[np.ndarray, "row"]


def time_to_collision(dx, dy, dvx, dvy, radius):
    """Return when two discs at constant velocities will touch [s]: 0 if they do now, infinite if they never will.

    The smallest t >= 0 with (dx + dvx t)^2 + (dy + dvy t)^2 = radius^2 (Hayward, 1972, in two dimensions). Displacement
    (dx, dy) [m] and relative velocity (dvx, dvy) [m/s] broadcast; ``radius`` is the distance at which centres touch.
    """
    approach = -(dx * dvx + dy * dvy)
    speed2, outside = dvx**2 + dvy**2, dx**2 + dy**2 - radius**2
    discriminant = approach**2 - speed2 * outside
    course = (approach > 0) & (discriminant >= 0)
    # the quadratic's smaller root, in a form without cancellation at low relative speeds
    root = approach + np.sqrt(np.maximum(discriminant, 0))
    later = np.divide(outside, root, out=np.full(np.shape(root), np.inf), where=course)
    return np.where(outside < 0, 0.0, later)


def reach(config: SimConfig) -> float:
    """Return the largest distance between the centres of a car and a pedestrian whose bodies touch [m]."""
    return float(np.hypot(config.car_length, config.car_width)) / 2 + config.body_radius


def time_to_contact(ahead: Column, left: Column, v_ahead: Column, v_left: Column, config: SimConfig) -> Column:
    """Return when the body will touch the car's rectangle [s]: 0 if it does now, infinite if it never will.

    The centres that touch fill the rectangle, widened by the body's radius, with rounded corners: two rectangles and
    four discs. The first of their times is the answer.
    """
    found = np.full(ahead.shape, np.inf)
    near = np.isfinite(time_to_collision(ahead, left, v_ahead, v_left, reach(config)))
    x, y, vx, vy = (column[near] for column in (ahead, left, v_ahead, v_left))
    half_length, half_width, radius = config.car_length / 2, config.car_width / 2, config.body_radius
    times = [
        _time_to_box(x, y, vx, vy, half_length + radius, half_width),
        _time_to_box(x, y, vx, vy, half_length, half_width + radius),
    ]
    for front, side in product((-half_length, half_length), (-half_width, half_width)):
        times.append(time_to_collision(x - front, y - side, vx, vy, radius))
    inside = to_rectangle(x, y, config.car_length, config.car_width) < radius
    found[near] = np.where(inside, 0.0, np.minimum.reduce(times))
    return found


def _time_to_box(x: Column, y: Column, vx: Column, vy: Column, half_length: float, half_width: float) -> Column:
    """Return when a point enters a rectangle about the origin [s]; infinite if it never does, or has left it."""
    enter_x, leave_x = _crossing_times(x, vx, half_length)
    enter_y, leave_y = _crossing_times(y, vy, half_width)
    enter, leave = np.maximum(enter_x, enter_y), np.minimum(leave_x, leave_y)
    return np.where((enter <= leave) & (leave >= 0), np.maximum(enter, 0), np.inf)


def _crossing_times(x: Column, v: Column, half: float) -> tuple[Column, Column]:
    """Return when a coordinate enters and leaves [-half, half] [s]; never enters or always inside if it stands."""
    standing, within = v == 0, np.abs(x) <= half
    speed = np.where(standing, 1.0, np.abs(v))
    towards = -x * np.sign(v)
    enter, leave = (towards - half) / speed, (towards + half) / speed
    return (
        np.where(standing, np.where(within, -np.inf, np.inf), enter),
        np.where(standing, np.where(within, np.inf, -np.inf), leave),
    )


def required_deceleration(ttc, speed):
    """Return the constant deceleration of the relative motion that just avoids a touch (DRAC) [m/s2].

    speed^2 / (2 x distance to collision) = speed / (2 TTC), with the relative speed [m/s]: Almqvist et al. (1991),
    Archer (2005), along the relative velocity. The result is 0 off a collision course, and NaN after a touch.
    """
    ttc, speed = np.broadcast_arrays(ttc, speed)
    return np.divide(speed, 2 * ttc, out=np.full(speed.shape, np.nan), where=ttc > 0)


def near_car(trajectory: Trajectory, config: SimConfig) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frame, episode and pedestrian wherever they may touch by any rule, in the order of `rows_of`."""
    # (two comparisons are enough to leave out nearly everybody, and hold only one large array at a time)
    metres = max(reach(config), config.collision_distance)
    near = real_frames(trajectory)[..., None]
    for axis in "xy":
        apart = getattr(trajectory, f"ped_{axis}") - getattr(trajectory, f"car_{axis}")[..., None]
        near = near & (np.abs(apart, out=apart) < metres)
    return rows_of(near)


def in_car_frame(
    trajectory: Trajectory, frame: np.ndarray, episode: np.ndarray, ped: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far pedestrians are ahead of the car and to its left [m], for the given rows."""
    car, person = (frame, episode), (frame, episode, ped)
    dx, dy = (getattr(trajectory, f"ped_{x}")[person] - getattr(trajectory, f"car_{x}")[car] for x in "xy")
    ahead, left = to_frame(dx, dy, trajectory.car_cos[car], trajectory.car_sin[car])
    return ahead, left


FRONT, SIDE, REAR = 1, 2, 3
"""The parts of the car that a body can touch."""


def touched_part(
    ahead: Column, left: Column, before_ahead: Column, before_left: Column, config: SimConfig
) -> tuple[Int[np.ndarray, "row"], Column]:
    """Return which part of the car a body touched first, and where, from its places after and before the contact.

    Between the two it moved straight in the car's frame. The place is in per cent of the car's width, 0 at its right
    edge and 100 at its left; it is NaN for the sides.
    """
    half_length = config.car_length / 2 + config.body_radius
    half_width = config.car_width / 2 + config.body_radius
    vx, vy = ahead - before_ahead, left - before_left
    enter_x, _ = _crossing_times(before_ahead, vx, half_length)
    enter_y, _ = _crossing_times(before_left, vy, half_width)
    part = np.where(enter_x >= enter_y, np.where(before_ahead > 0, FRONT, REAR), SIDE)
    share = np.clip(np.where(part == SIDE, 0, enter_x), 0, 1)
    place = 100 * ((before_left + share * vy) / config.car_width + 0.5)
    return part, np.where(part == SIDE, np.nan, np.clip(place, 0, 100))
