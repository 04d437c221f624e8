"""The RSS shield: the car brakes where people and it could meet although both respond as they should."""

from __future__ import annotations

from dataclasses import dataclass

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.interfaces import View
from jaxwalk.policies.shields.shield_scene import Around, ShieldScene, Verdict
from jaxwalk.safety.bicycle import held_turn
from jaxwalk.safety.rss import (
    CAR,
    PERSON,
    Response,
    braking_way,
    distance_to_sector,
    forward_way,
    turn_until_response,
)
from jaxwalk.sim.events import distance
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.state import Motion
from jaxwalk.sim.world import Rules

PLACES = 16
"""The car is looked at in this many places along a way."""
DISCS = (-1 / 3, 0, 1 / 3)
"""Three discs cover the car: their centres lie so far ahead of its own, as shares of its length."""


@dataclass(frozen=True)
class Way:
    """Where discs that cover the car come along its way; arrays ``(place, disc, 1, *batch)``, for everybody at once."""

    ahead: Float[Array, "place disc 1 *batch"]
    left: Float[Array, "place disc 1 *batch"]
    radius: Float[Array, ""]
    """Radius of each disc, with a body beside it [m]."""


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
        brakes, goes_on = (_way(rules, how(car.speed, response), steering) for how in (braking_way, forward_way))
        speed = distance(scene.people.ahead_speed, scene.people.left_speed)
        car_must = _meets(brakes, scene.people, forward_way(speed, PERSON))
        both_must = car_must & _meets(goes_on, scene.people, braking_way(speed, PERSON))
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


def _way(rules: Rules, length: Float[Array, "*batch"], steering: Float[Array, "*batch"]) -> Way:
    """Return the car's way of a length [m] with a held steering angle [rad]."""
    share = jnp.linspace(0, 1, PLACES).reshape(-1, 1, 1, *(1,) * length.ndim)
    beyond = rules.car_length * jnp.array(DISCS).reshape(-1, 1, *(1,) * length.ndim)
    ahead, left, turn = held_turn(share * length, steering, rules.wheelbase)
    radius = distance(rules.car_length / (2 * len(DISCS)), rules.car_width / 2) + rules.body_radius
    if rules.contact == "disc":
        beyond, radius = 0 * beyond, rules.collision_distance
    return Way(ahead + beyond * jnp.cos(turn), left + beyond * jnp.sin(turn), radius)


def _meets(way: Way, people: Motion, reach: Float[Array, "ped *batch"]) -> Bool[Array, "ped *batch"]:
    """Return whose sector of that radius [m] the car's way meets."""
    speed = distance(people.ahead_speed, people.left_speed)
    norm = 1 / jnp.maximum(speed, 1e-6)
    there = way.ahead - people.ahead, way.left - people.left
    along, aside = to_frame(*there, people.ahead_speed * norm, people.left_speed * norm)
    standing = speed < 1e-6  # it has no direction, and needs none
    along, aside = jnp.where(standing, there[0], along), jnp.where(standing, there[1], aside)
    return (distance_to_sector(along, aside, turn_until_response(speed), reach) < way.radius).any(axis=(0, 1))
