"""What a car knows of what it doesn't see: who was there a moment ago, and which sides of its way are hidden."""

from __future__ import annotations

from collections.abc import Sequence

import jax.numpy as jnp
from jaxtyping import Array

from jaxwalk.interfaces import Moment
from jaxwalk.sim.driver_features import person_bounds, person_rows
from jaxwalk.sim.features import Bound, Feature, Limits, share
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.map_tables import POINTS
from jaxwalk.sim.perceived import KEPT
from jaxwalk.sim.prediction import NEIGHBOURS, nearest_and, nobody, perceived_people
from jaxwalk.sim.sight import in_sight

SIDES = (-5.0, 8.5)
"""Offsets to the left of the route at which a car looks for hidden places [m]: beyond parked vehicles on its own side,
and on a two-lane road beyond those on the other side."""


def _last_seen(moment: Moment) -> Sequence[Array]:
    """Return the nearest people who were perceived at most `KEPT` ago and aren't now, 5 numbers each, nearest first.

    Place and velocity are those of that moment; the fifth number is 1 if it has just passed and falls to 0.
    """
    car, knows = moment.state.vehicle, moment.state.perceived
    if knows is None:
        motion, fresh = nobody(car.x.shape), jnp.zeros((NEIGHBOURS, *car.x.shape))
    else:
        lost = knows.last.seen & ~knows.now.seen
        left = jnp.where(lost, jnp.maximum(1 - knows.age / KEPT, 0), 0)
        motion, fresh = nearest_and(perceived_people(car, knows.last, lost), left)
    rows = jnp.concatenate([person_rows(motion), fresh[:, None]], axis=1)
    return (rows.reshape(-1, *car.x.shape),)


def _last_seen_bounds(limits: Limits) -> Sequence[Bound]:
    return [*person_bounds(limits), (0.0, 1.0)]


def _hidden_sides(moment: Moment) -> Sequence[Array]:
    """Return 1 for each place beside the route ahead that something hides, or that is out of the range of sight.

    The places are `SIDES` to the left of the points of the route, the nearest point first.
    """
    world, car, seen = moment.world, moment.state.vehicle, moment.state.foresight
    if moment.state.perceived is None:
        return (jnp.zeros((len(SIDES) * len(POINTS), *car.x.shape)),)
    ahead, left = seen.route_x, seen.route_y
    dx, dy = (jnp.diff(along, axis=0, prepend=0) for along in (ahead, left))
    length = jnp.maximum(jnp.sqrt(dx * dx + dy * dy), 1e-3)
    aside = jnp.array(SIDES).reshape(1, -1, *(1,) * car.x.ndim)
    place_ahead = (ahead[:, None] - aside * (dy / length)[:, None]).reshape(-1, *car.x.shape)
    place_left = (left[:, None] + aside * (dx / length)[:, None]).reshape(-1, *car.x.shape)
    x, y = to_frame(place_ahead, place_left, car.cos[None], -car.sin[None])
    return (~in_sight(world, moment.scenario, car, car.x[None] + x, car.y[None] + y),)


LAST_SEEN = Feature("last_seen", 5 * NEIGHBOURS, _last_seen_bounds, _last_seen)
"""Who was last seen."""
HIDDEN_SIDES = Feature("hidden_sides", len(SIDES) * len(POINTS), share, _hidden_sides)
"""Where the sides of the car's way are hidden."""
