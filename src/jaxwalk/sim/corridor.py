"""People in the frame of the car's route: how far along it they are, how far beside it, and which crosswalks they near.

For rule-based drivers, whose formulas speak of a car's way and of who comes into it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import vehicle
from jaxwalk.sim.crossing_kind import CROSSWALK
from jaxwalk.sim.driver_features import METRES, ON_ROUTE, SPEEDS
from jaxwalk.sim.events import distance
from jaxwalk.sim.everybody import for_everybody
from jaxwalk.sim.features import SPEED, Bound, Feature, Limits, both
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.prediction import DISTANCE, of_lowest
from jaxwalk.sim.what_if import ASIDE, BEHIND, WALKING, crosswalk_ends, walkers

WATCHED = 8
"""The car watches this many people: the nearest of those ahead along its route."""
BESIDE = 12.0
"""People farther beside the route than this are not watched [m]."""
NEARING = 10.0
"""People who walk to a crosswalk are noticed from this way to its end on [m]."""
AT_END, ACROSS_WALK = 2.0, 4.0
"""Who is up to `AT_END` to either side of a crosswalk's end or behind it, or between it and the kerb, at most
`ACROSS_WALK` on, is at the crosswalk [m]."""
LEADS_OVER = 0.5
"""A crosswalk leads over the route if its direction is at least this share of the direction straight to the route."""
PER_PERSON = 5
"""Numbers shown of each."""
SHORTEST = 1e-3
"""Pieces of the route shorter than this have no direction: the route has ended [m]."""
SAME = 1e-3
"""Where pieces of the route meet, both may be equally near: the first one counts unless a later is this much nearer
[m2], so that rounding doesn't decide in which direction the route leads there."""


def on_route(moment: Moment) -> tuple[Array, Array, Array, Array]:
    """Return people's way along the car's route and to the left of it [m], and its direction there; ``(ped, *batch)``.

    The way begins at the car's centre and leads straight from one point of the route ahead to the next; its ends go on
    straight. The direction is a unit vector in the car's frame. Who isn't perceived is far ahead
    (`jaxwalk.sim.prediction.AWAY`).
    """
    seen = moment.state.foresight
    people, zero = seen.people, jnp.zeros_like(seen.route_x[0])
    pieces = list(pairwise(zip((zero, *seen.route_x), (zero, *seen.route_y), strict=True)))
    lengths = [distance(to[0] - at[0], to[1] - at[1]) for at, to in pieces]
    nearest = jnp.full_like(people.ahead, jnp.inf)
    along, left, cos, sin = people.ahead, people.left, jnp.ones_like(nearest), jnp.zeros_like(nearest)
    begin = zero
    for number, ((x, y), (to_x, to_y)) in enumerate(pieces):
        length = lengths[number]
        unit_x, unit_y = (step / jnp.maximum(length, SHORTEST) for step in (to_x - x, to_y - y))
        ends_here = sum(lengths[number + 1 :], start=zero) < SHORTEST
        ahead, aside = to_frame(people.ahead - x, people.left - y, unit_x, unit_y)
        on_piece = jnp.clip(ahead, -jnp.inf if number == 0 else 0, jnp.where(ends_here, jnp.inf, length))
        squared = jnp.where(length < SHORTEST, jnp.inf, (ahead - on_piece) ** 2 + aside**2)
        closer = squared < nearest - SAME
        away = jnp.where(aside < 0, -1.0, 1.0) * jnp.sqrt(squared)
        found = (begin + on_piece, away, unit_x, unit_y)
        along, left, cos, sin = (
            jnp.where(closer, new, old) for new, old in zip(found, (along, left, cos, sin), strict=True)
        )
        nearest, begin = jnp.minimum(squared, nearest), begin + length
    return along, left, cos, sin


def way_to_crosswalk(
    moment: Moment, left: Float[Array, "ped *batch"], cos: Float[Array, "ped *batch"], sin: Float[Array, "ped *batch"]
) -> Float[Array, "ped *batch"]:
    """Return how far people walk until they are at a crosswalk over the car's route [m], at most `NEARING`.

    It is 0 for who is on a crosswalk, on the roadway, or at the end of one that leads over the route; for who walks
    straight to such an end, the way there. What they intend isn't known.

    Args:
        moment: the moment.
        left: how far people are to the left of the route [m].
        cos: the route's direction near them, in the car's frame.
        sin: its second coordinate.
    """
    car, people = moment.state.vehicle, walkers(moment)
    to_route = jnp.where(left > 0, 1.0, -1.0)  # straight to the route is to its right for who is to the left
    ahead, aside = to_route * sin, -to_route * cos
    to_route_x, to_route_y = to_frame(ahead, aside, car.cos[None], -car.sin[None])
    speed = distance(people.velocity_x, people.velocity_y)
    pace = jnp.maximum(speed, WALKING)

    def look_at(end: tuple[Array, ...], found: Array) -> Array:
        x, y, over_x, over_y = end
        dx, dy = x - people.x, y - people.y
        leads_over = over_x * to_route_x + over_y * to_route_y > LEADS_OVER
        beyond, beside = to_frame(-dx, -dy, over_x, over_y)
        at_end = (jnp.abs(beside) < AT_END) & (beyond > -AT_END) & (beyond < ACROSS_WALK)
        way = (dx * people.velocity_x + dy * people.velocity_y) / pace
        off = jnp.abs(dx * people.velocity_y - dy * people.velocity_x) / pace
        walks_there = (speed > WALKING) & (off < ASIDE) & (way > -BEHIND)
        way = jnp.where(at_end, 0.0, jnp.where(walks_there, jnp.maximum(way, 0), NEARING))
        return jnp.where(leads_over, jnp.minimum(way, found), found)

    off_roadway = for_everybody(crosswalk_ends(moment), look_at, jnp.full_like(speed, NEARING))
    on_crosswalk = jnp.where(people.crossing == CROSSWALK, 0.0, NEARING)
    return jnp.where(people.on_roadway, on_crosswalk, off_roadway)


def _watched(moment: Moment) -> Sequence[Array]:
    """Return the nearest of the people ahead along the route, `PER_PERSON` numbers each, nearest first.

    They are the way along the route and to its left, the speeds in these directions, and the way to a crosswalk. One
    who isn't there stands far ahead, beside the route.
    """
    people, batch = moment.state.foresight.people, moment.state.step.shape
    along, left, cos, sin = on_route(moment)
    speeds = to_frame(people.ahead_speed, people.left_speed, cos, sin)
    near = (along > 0) & (along < DISTANCE) & (jnp.abs(left) < BESIDE)
    nobody = (DISTANCE, BESIDE, 0.0, 0.0, NEARING)
    columns = (along, left, *speeds, way_to_crosswalk(moment, left, cos, sin))
    shown = tuple(jnp.where(near, column, away) for column, away in zip(columns, nobody, strict=True))
    absent = tuple(jnp.full((WATCHED, *batch), away) for away in nobody)
    picked = of_lowest(shown[0] ** 2 + shown[1] ** 2, shown, absent)
    scaled = [column / scale for column, scale in zip(picked, (DISTANCE, DISTANCE, SPEED, SPEED, NEARING), strict=True)]
    return (jnp.stack(scaled, axis=1).reshape(-1, *batch),)


def _watched_bounds(limits: Limits) -> Sequence[Bound]:
    walk = both(limits.config.fastest / SPEED)
    return [(0.0, 1.0), both(BESIDE / DISTANCE), walk, walk, (0.0, 1.0)]


TOP_SPEED = Feature(
    "top_speed",
    1,
    lambda limits: [(0.0, limits.config.max_speed / SPEED)],
    lambda m: (vehicle.top_speed(m.world, m.state.vehicle) / SPEED,),
    (SPEEDS,),
)
"""The car's top speed here, by its own and by the speed limit."""
WATCHED_PEOPLE = Feature(
    "watched",
    PER_PERSON * WATCHED,
    _watched_bounds,
    _watched,
    (METRES, METRES, SPEEDS, SPEEDS, f"{NEARING:g} m"),
)
"""The nearest people ahead, in the frame of the route."""
CORRIDOR = (*ON_ROUTE, TOP_SPEED, WATCHED_PEOPLE)
"""The car in the frame of its route 22, its top speed 1, people in the frame of its route 40."""
