"""What a pedestrian can see: features, arrays ``(number, ped, *batch)``."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import pedestrian, prediction, vehicle
from jaxwalk.sim.crossing_kind import JAYWALK, LegKind
from jaxwalk.sim.everybody import for_everybody, index_of, with_index
from jaxwalk.sim.features import (
    COSINE,
    FLAG,
    OF_MAP,
    PURE,
    SPEED,
    Bound,
    Feature,
    Limits,
    both,
    on_map,
    share,
    signed,
    within_diagonals,
)
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.prediction import DISTANCE
from jaxwalk.sim.state import Motion

KERB_CAR_DISTANCE = 40.0
"""A pedestrian at the kerb decides whether to wait only while the car is within this distance [m]; for a car whose top
speed is above 8.33 m/s the distance grows with it, to 67 m in the world ``town``."""
PASSED = 2.5
"""It decides no longer once the car is this far past it [m]: a car does not come back."""
LONG = 8.0
"""Longest time in an observation [s]; longer ones are shown as this."""
METRES, SPEEDS, PACES = f"{DISTANCE:g} m", f"{SPEED:g} m/s", "2 m/s"
"""Units of distances, of the car's speed and of walking speeds."""


def _in_cars_frame(moment: Moment) -> Motion:
    return prediction.motion_of_people(moment.world, moment.scenario, moment.state)


def _of_car(compute: Callable[[Moment], Sequence[Array]], unseen: Sequence[float]) -> Callable[..., Sequence[Array]]:
    """Return a formula that gives the ``unseen`` numbers to people who don't see the car."""

    def in_sight(moment: Moment) -> Sequence[Array]:
        rows, perceived = compute(moment), moment.state.perceived
        if perceived is None:
            return rows
        return [jnp.where(perceived.in_sight, row, number) for row, number in zip(rows, unseen, strict=True)]

    return in_sight


def _next_waypoint(moment: Moment) -> Sequence[Array]:
    people = moment.state.pedestrian
    return (people.leg.end_x - people.x) / DISTANCE, (people.leg.end_y - people.y) / DISTANCE


def _surface(moment: Moment) -> Sequence[Array]:
    """Return flags: on no roadway, on a crosswalk, on a roadway off the crosswalks."""
    people = moment.state.pedestrian
    on_roadway, on_crosswalk = people.on_roadway, people.on_crosswalk
    return ~on_roadway, on_roadway & on_crosswalk, on_roadway & ~on_crosswalk


def _car_position(moment: Moment) -> Sequence[Array]:
    car, people = moment.state.vehicle, moment.state.pedestrian
    return (car.x[None] - people.x) / DISTANCE, (car.y[None] - people.y) / DISTANCE


def _car_velocity(moment: Moment) -> Sequence[Array]:
    car = moment.state.vehicle
    return (car.speed * car.cos)[None] / SPEED, (car.speed * car.sin)[None] / SPEED


def _nearest_other(moment: Moment) -> Sequence[Array]:
    """Return the vector from each pedestrian to the nearest other one; 60 m ahead where nobody is nearer."""
    x, y = moment.state.pedestrian.x, moment.state.pedestrian.y
    people, order = x.shape[0], jnp.arange(x.shape[0]).reshape((-1,) + (1,) * (x.ndim - 1))

    def compare(other: tuple[Array, Array, Array], nearest: Array) -> Array:
        other_x, other_y, index = other
        key = with_index((other_x - x) ** 2 + (other_y - y) ** 2, index, people)
        return jnp.where((key < nearest) & (index != order), key, nearest)

    nobody = jnp.broadcast_to(with_index(jnp.float32(DISTANCE**2), jnp.int32(people), people), x.shape)
    key = for_everybody((x, y, order), compare, nobody)

    def pick(other: tuple[Array, Array, Array], found: tuple[Array, Array]) -> tuple[Array, Array]:
        other_x, other_y, index = other
        chosen = index_of(key, people) == index
        return jnp.where(chosen, other_x - x, found[0]), jnp.where(chosen, other_y - y, found[1])

    found = for_everybody((x, y, order), pick, (jnp.full_like(x, DISTANCE), jnp.zeros_like(x)))
    return found[0] / DISTANCE, found[1] / DISTANCE


def _decides(moment: Moment) -> Sequence[Array]:
    """Return who has something to decide: at the kerb, on the leg into the roadway, the car near and not yet past."""
    seen, people = _in_cars_frame(moment), moment.state.pedestrian
    within = KERB_CAR_DISTANCE * jnp.maximum(moment.world.rules.max_speed / SPEED, 1)
    close = (seen.ahead * seen.ahead + seen.left * seen.left < within**2) & (seen.ahead > -PASSED)
    decides = pedestrian.at_kerb(moment.world, people) & pedestrian.enters_roadway(people) & close
    return (decides if moment.state.perceived is None else decides & moment.state.perceived.in_sight,)


def _place(moment: Moment) -> Sequence[Array]:
    """Return each pedestrian's position in the car's frame."""
    seen = _in_cars_frame(moment)
    return seen.ahead / KERB_CAR_DISTANCE, seen.left / KERB_CAR_DISTANCE


def _car_motion(moment: Moment) -> Sequence[Array]:
    """Return the car's speed, acceleration and steering."""
    car, world = moment.state.vehicle, moment.world
    steering = car.steering / world.rules.max_steering
    return _speed_for_everybody(moment) / SPEED, vehicle.throttle(world, car)[None], steering[None]


def _car_motion_bounds(limits: Limits) -> Sequence[Bound]:
    return [(0.0, limits.config.max_speed / SPEED), *signed(limits), *signed(limits)]


def _direction(moment: Moment) -> tuple[Array, Array]:
    """Return the direction of the leg in the car's frame."""
    car, leg = moment.state.vehicle, moment.state.pedestrian.leg
    return to_frame(leg.cos, leg.sin, car.cos[None], car.sin[None])


def _times(moment: Moment) -> Sequence[Array]:
    """Return when car and pedestrian would reach the point where their paths cross, and the difference."""
    seen, (_, across) = _in_cars_frame(moment), _direction(moment)
    crossing_speed = pedestrian.pace(moment.world, moment.scenario, moment.state.pedestrian) * across
    toward = seen.left * crossing_speed < 0
    own_time = jnp.where(toward, -seen.left / jnp.where(toward, crossing_speed, 1), LONG)
    car_time = seen.ahead / jnp.maximum(_speed_for_everybody(moment), 0.5)
    return (
        jnp.clip(car_time, -LONG, LONG) / LONG,
        jnp.minimum(own_time, LONG) / LONG,
        jnp.clip(car_time - own_time, -LONG, LONG) / LONG,
    )


def _times_bounds(limits: Limits) -> Sequence[Bound]:
    return [*signed(limits), *share(limits), *signed(limits)]


def _miss(moment: Moment) -> Sequence[Array]:
    """Return how close car and pedestrian would come if the pedestrian goes now, and when."""
    miss, closest = prediction.predicted_miss(moment.world, moment.scenario, moment.state)
    return jnp.minimum(miss, 10) / 10, jnp.minimum(closest, LONG) / LONG


def _pace_bounds(limits: Limits) -> Sequence[Bound]:
    slowest, fastest = limits.config.walking
    return [(slowest / 2, fastest / 2)]


def _to_kerb(moment: Moment) -> Sequence[Array]:
    return (jnp.clip(moment.state.pedestrian.to_kerb, -1, moment.world.rules.kerb_distance),)


def _velocity(moment: Moment) -> Sequence[Array]:
    return [metres / 2 for metres in pedestrian.velocity(moment.world, moment.scenario, moment.state.pedestrian)]


def _speed_for_everybody(moment: Moment) -> Float[Array, "ped *batch"]:
    """Return the car's speed once for each pedestrian [m/s]."""
    return jnp.broadcast_to(moment.state.vehicle.speed[None], moment.state.pedestrian.x.shape)


PAPER = (
    Feature("position", 2, share, lambda m: on_map(m, m.state.pedestrian.x, m.state.pedestrian.y), OF_MAP),
    Feature("velocity", 2, lambda limits: [both(limits.config.fastest / 2)], _velocity, (PACES,)),
    Feature("traits", 4, share, lambda m: (m.scenario.own_traits(m.world),), PURE),
    Feature("next_waypoint", 2, within_diagonals(DISTANCE), _next_waypoint, (METRES,)),
    Feature("surface", 3, share, _surface, FLAG),
    Feature("on_jaywalk", 1, share, lambda m: (m.state.pedestrian.leg.kind == LegKind.ACROSS,), FLAG),
    Feature("car_position", 2, within_diagonals(DISTANCE), _of_car(_car_position, (1.0, 0.0)), (METRES,)),
    Feature(
        "car_velocity",
        2,
        lambda limits: [both(limits.config.max_speed / SPEED)],
        _of_car(_car_velocity, (0.0, 0.0)),
        (SPEEDS,),
    ),
    Feature(
        "nearest_other", 2, lambda limits: [both(max(limits.diagonal, DISTANCE) / DISTANCE)], _nearest_other, (METRES,)
    ),
)
"""The paper's 20: own position 2, velocity 2, traits 4, next waypoint 2, surface 3, on a jaywalk 1, the car's relative
position 2 and velocity 2, nearest other pedestrian 2. Relative positions are in the map's axes."""

KERB = (
    Feature("decides", 1, share, _decides, FLAG),
    Feature(
        "place", 2, within_diagonals(KERB_CAR_DISTANCE), _of_car(_place, (1.0, 0.0)), (f"{KERB_CAR_DISTANCE:g} m",)
    ),
    Feature(
        "car_motion",
        3,
        _car_motion_bounds,
        _of_car(_car_motion, (0.0, 0.0, 0.0)),
        (SPEEDS, "largest acceleration or braking", "largest steering angle"),
    ),
    Feature("direction", 2, signed, _of_car(_direction, (0.0, 0.0)), COSINE),
    Feature("times", 3, _times_bounds, _of_car(_times, (1.0, 1.0, 0.0)), (f"{LONG:g} s",)),
    Feature("miss", 2, share, _of_car(_miss, (1.0, 1.0)), ("10 m", f"{LONG:g} s")),
    Feature("pace", 1, _pace_bounds, lambda m: (m.scenario.walking_speed(m.world) / 2,), (PACES,)),
    Feature(
        "traits",
        3,
        share,
        lambda m: (m.scenario.jaywalking_tendency(m.world), m.scenario.traits[2], m.scenario.traits[3]),
        PURE,
    ),
    Feature("jaywalk", 1, share, lambda m: (m.state.pedestrian.crossing == JAYWALK,), FLAG),
    Feature("to_kerb", 1, lambda limits: [(-1.0, limits.config.kerb_distance)], _to_kerb, ("1 m",)),
)
"""What matters for stepping into the road: whether there is anything to decide 1, the pedestrian's position, the car's
motion and the direction of the leg 7, the times at which both would reach the point where their paths cross 3, how
close they would come if the pedestrian goes now 2, pace, traits, jaywalk and way to the kerb 6. Vectors are in the
car's frame."""
