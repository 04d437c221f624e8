"""The RSS shield: the car brakes where people and it could meet although both respond as they should."""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.columns import apply_where
from jaxwalk.interfaces import View
from jaxwalk.policies.shields.shield_scene import Around, ShieldScene, Verdict
from jaxwalk.safety.bicycle import held_turn
from jaxwalk.safety.rss import (
    CAR,
    PERSON,
    Response,
    braking_way,
    forward_way,
    near_sector,
    turn_until_response,
)
from jaxwalk.sim.events import distance
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.state import Motion
from jaxwalk.sim.world import Rules

PLACES = 16
"""The car is looked at in this many places along a way."""
PART = 16
"""Pairs of a car and a person that could meet are looked at one part in 16 of all pairs at once."""
DISCS = (-1 / 3, 0, 1 / 3)
"""Three discs cover the car: their centres lie so far ahead of its own, as shares of its length."""


class RssShield(eqx.Module):
    """Brakes while the car's braking way meets somebody's forward way, unless only the other one must brake.

    That is so where the other one's braking way doesn't meet the car's forward way. Definition 22 of RSS also lets the
    car go on if nobody's braking ways meet; people here need not brake, so that is left out.
    """

    view: View = eqx.field(static=True, default=Around())
    """What it sees."""

    def judge(self, action: Float[Array, "2 *batch"], scene: ShieldScene) -> Verdict:
        """Return whether nothing is dangerous or the action brakes enough, and that much braking as steered."""
        rules, car = scene.world.rules, scene.car
        response = response_of(rules)
        steering = rules.max_steering * jnp.clip(action[1], -1, 1)
        speed = distance(scene.people.ahead_speed, scene.people.left_speed)
        everybody = (scene.people, jnp.broadcast_to(steering, speed.shape))

        def who_meets(way: Array, reach: Array, among: Array) -> Array:
            pairs = (*everybody, jnp.broadcast_to(way, speed.shape), reach)
            return apply_where(lambda pair: _meets(rules, *pair), pairs, among & _could_meet(rules, *pairs), PART)

        car_must = who_meets(braking_way(car.speed, response), forward_way(speed, PERSON), jnp.bool_(True))
        both_must = who_meets(forward_way(car.speed, response), braking_way(speed, PERSON), car_must)
        pedal = -response.braking / rules.max_braking
        safe = ~both_must.any(axis=0) | (action[0] <= pedal)
        return Verdict(safe, jnp.stack([jnp.full_like(action[1], pedal), action[1]]), jnp.zeros_like(safe))


def response_of(rules: Rules) -> Response:
    """Return how the world's car responds: as `CAR`, or by what it can do."""
    return Response(
        reaction=CAR.reaction,
        acceleration=jnp.minimum(CAR.acceleration, rules.max_acceleration),
        braking=jnp.minimum(CAR.braking, rules.max_braking),
        fastest=rules.max_speed,
    )


def _discs(rules: Rules) -> tuple[Float[Array, "disc"], Float[Array, ""]]:
    """Return how far ahead of its centre the discs are that cover the car, and their radius with a body beside [m]."""
    beyond = rules.car_length * jnp.array(DISCS)
    if rules.contact == "disc":
        return 0 * beyond, rules.collision_distance
    return beyond, distance(rules.car_length / (2 * len(DISCS)), rules.car_width / 2) + rules.body_radius


def _could_meet(
    rules: Rules, people: Motion, steering: Float[Array, "*pair"], way: Float[Array, "*pair"],
    reach: Float[Array, "*pair"],
) -> Bool[Array, "*pair"]:  # fmt: skip
    """Return whose sector the car's way could meet if both went straight at each other; arguments as of `_meets`."""
    beyond, radius = _discs(rules)
    return distance(people.ahead, people.left) <= way + reach + beyond.max() + radius


def _meets(
    rules: Rules, person: Motion, steering: Float[Array, "*pair"], way: Float[Array, "*pair"],
    reach: Float[Array, "*pair"],
) -> Bool[Array, "*pair"]:  # fmt: skip
    """Return whose sector the car's way meets.

    Args:
        rules: the car's size.
        person: one for each pair of a car and a person.
        steering: the car's held steering angle [rad].
        way: length of its way [m].
        reach: radius of the person's sector [m].
    """
    share = jnp.linspace(0, 1, PLACES).reshape(-1, 1, *(1,) * way.ndim)
    beyond, radius = _discs(rules)
    beyond = beyond.reshape(-1, *(1,) * way.ndim)
    ahead, left, turn = held_turn(share * way, steering, rules.wheelbase)
    there = ahead + beyond * jnp.cos(turn) - person.ahead, left + beyond * jnp.sin(turn) - person.left
    speed = distance(person.ahead_speed, person.left_speed)
    norm = 1 / jnp.maximum(speed, 1e-6)
    along, aside = to_frame(*there, person.ahead_speed * norm, person.left_speed * norm)
    standing = speed < 1e-6  # it has no direction, and needs none
    point = jnp.where(standing, there[0], along), jnp.where(standing, there[1], aside)
    return near_sector(point, turn_until_response(speed), reach, radius).any(axis=(0, 1))
