"""How close the car would come to people if they stepped onto the roadway where they may: what no walk foretells."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import pedestrian
from jaxwalk.sim.events import distance
from jaxwalk.sim.everybody import for_everybody
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.lookup import of_map
from jaxwalk.sim.prediction import predict
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.sim.state import Foresight, Motion

SETTING_OUT, WALKING = 1.3, 0.1
"""People slower than `WALKING` stand; if they set out, it is at `SETTING_OUT` [m/s]."""
ASIDE, BEHIND = 1.0, 0.2
"""Who passes a crosswalk's end within `ASIDE` metres, or passed it less than `BEHIND` metres ago, may turn there."""
NEVER = 1e6
"""When people turn who walk to no crosswalk [s]."""


def clearance_if_they_turn(moment: Moment, contact: ContactRule) -> tuple[Array, Array]:
    """Return ``clearance`` and ``conflict`` as if everybody off the roadway turned to the car's route now.

    They walk straight to its nearest point, as fast as before; people who stand set out.
    """
    seen = moment.state.foresight
    ahead, left = _to_route(seen)
    away = jnp.maximum(distance(ahead, left), 1e-2)
    speed = distance(seen.people.ahead_speed, seen.people.left_speed)
    pace = jnp.where(speed > WALKING, speed, SETTING_OUT) / away
    stays = walkers(moment).on_roadway
    turning = Motion(
        ahead=seen.people.ahead,
        left=seen.people.left,
        ahead_speed=jnp.where(stays, seen.people.ahead_speed, pace * ahead),
        left_speed=jnp.where(stays, seen.people.left_speed, pace * left),
    )
    return predict(moment, turning, contact)


class Turn(eqx.Module):
    """People who walk on as they do, and then turn; arrays ``(ped, *batch)``."""

    now: Motion
    when: Float[Array, "_ *batch"]
    """When they turn [s]."""
    ahead_speed: Float[Array, "_ *batch"]
    """Velocity over ground from then on, in the direction of the car's heading [m/s]."""
    left_speed: Float[Array, "_ *batch"]
    """The same to the left."""

    def at(self, time: Array) -> tuple[Array, Array]:
        """Return how far ahead and to the left of the car people are after some time [s], in metres."""
        ahead, left = self.now.at(jnp.minimum(time, self.when))
        after = jnp.maximum(time - self.when, 0)
        return ahead + self.ahead_speed * after, left + self.left_speed * after


def clearance_if_they_cross(moment: Moment, contact: ContactRule) -> tuple[Array, Array]:
    """Return ``clearance`` and ``conflict`` as if everybody who walks to the end of a crosswalk took it.

    They keep their pace. Who walks to several takes the nearest.
    """
    car, people, seen = moment.state.vehicle, walkers(moment), moment.state.foresight
    vx, vy = people.velocity_x, people.velocity_y
    speed = distance(vx, vy)
    pace = jnp.maximum(speed, WALKING)
    far_away = jnp.full_like(speed, NEVER)

    def look_at(crosswalk: tuple[Array, ...], found: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        x, y, cos, sin = crosswalk
        dx, dy = x - people.x, y - people.y
        along, aside = (dx * vx + dy * vy) / pace, jnp.abs(dx * vy - dy * vx) / pace
        nearer = (aside < ASIDE) & (along > -BEHIND) & (along < found[0])
        return jnp.where(nearer, along, found[0]), jnp.where(nearer, cos, found[1]), jnp.where(nearer, sin, found[2])

    begin = (far_away, jnp.zeros_like(speed), jnp.zeros_like(speed))
    away, cos, sin = for_everybody(crosswalk_ends(moment), look_at, begin)
    turns = (speed > WALKING) & ~people.on_roadway
    turning = Turn(
        seen.people,
        jnp.where(turns, away / pace, NEVER),
        *to_frame(pace * cos, pace * sin, car.cos[None], car.sin[None]),
    )
    return predict(moment, turning, contact)


class Walkers(NamedTuple):
    """People as the driver knows them; arrays ``(ped, *batch)``."""

    x: Array
    """Position [m]."""
    y: Array
    velocity_x: Array
    """Velocity [m/s]."""
    velocity_y: Array
    on_roadway: Array
    """Whether they are between the kerbs."""
    crossing: Array
    """The `jaxwalk.sim.crossing_kind.CrossingKind` of the crossing; only of people on the roadway it can be seen."""


def walkers(moment: Moment) -> Walkers:
    """Return people as perceived; who isn't perceived is nowhere near anyway (`jaxwalk.sim.prediction.AWAY`)."""
    if moment.state.perceived is not None:
        now = moment.state.perceived.now
        return Walkers(now.x, now.y, now.velocity_x, now.velocity_y, now.on_roadway, now.crossing)
    people = moment.state.pedestrian
    velocity = pedestrian.velocity(moment.world, moment.scenario, people)
    return Walkers(people.x, people.y, *velocity, people.on_roadway, people.crossing)


def crosswalk_ends(moment: Moment) -> tuple[Array, ...]:
    """Return x and y of every end of a crosswalk [m] and the unit vector across; arrays ``(side, *batch)``.

    Padding is far away.
    """
    maps = moment.world.maps
    real, landing = maps.side_landing >= 0, jnp.maximum(maps.side_landing, 0)
    x, y = (jnp.take_along_axis(node, landing, axis=-1) for node in (maps.node_x, maps.node_y))
    across_x, across_y = (_opposite(at) - at for at in (x, y))
    length = jnp.maximum(distance(across_x, across_y), 1e-6)
    columns = jnp.where(real, x, NEVER), y, across_x / length, across_y / length
    return tuple(of_map(column, moment.scenario.map) for column in columns)


def _opposite(of_side: Float[Array, "map side"]) -> Float[Array, "map side"]:
    """Return the value of the other side of each crossing."""
    return of_side.reshape(len(of_side), -1, 2)[..., ::-1].reshape(of_side.shape)


def _to_route(seen: Foresight) -> tuple[Array, Array]:
    """Return the way from each pedestrian to the nearest point of the route ahead, in the car's frame [m]."""
    people, zero = seen.people, jnp.zeros_like(seen.route_x[0])
    nearest, ahead, left = jnp.full_like(people.ahead, jnp.inf), people.ahead, people.left
    for (x, y), (to_x, to_y) in pairwise(zip((zero, *seen.route_x), (zero, *seen.route_y), strict=True)):
        dx, dy = to_x - x, to_y - y
        along = ((people.ahead - x) * dx + (people.left - y) * dy) / jnp.maximum(dx * dx + dy * dy, 1e-6)
        along = jnp.clip(along, 0, 1)
        to_ahead, to_left = x + along * dx - people.ahead, y + along * dy - people.left
        squared = to_ahead * to_ahead + to_left * to_left
        ahead, left = jnp.where(squared < nearest, to_ahead, ahead), jnp.where(squared < nearest, to_left, left)
        nearest = jnp.minimum(squared, nearest)
    return ahead, left
