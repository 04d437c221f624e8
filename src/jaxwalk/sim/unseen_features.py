"""What a car knows of what it doesn't see: who was there a moment ago, where its way is hidden, the next crosswalk."""

from __future__ import annotations

from collections.abc import Sequence

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.sim.driver_features import PERSON_UNITS, person_bounds, person_rows
from jaxwalk.sim.features import FLAG, Bound, Feature, Limits, share
from jaxwalk.sim.kerbsides import FARTHEST
from jaxwalk.sim.lookup import look_up_row
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.perceived import KEPT
from jaxwalk.sim.prediction import NEIGHBOURS, nearest_and, nobody, perceived_people
from jaxwalk.sim.sight import in_sight


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


def beside_the_route(moment: Moment) -> Float[Array, "column point *batch"]:
    """Return the columns of `jaxwalk.sim.kerbsides` where the car is, and then at the points of its route ahead."""
    table, scenario, car = moment.world.kerbsides, moment.scenario, moment.state.vehicle
    assert table is not None
    ahead = jnp.array((0, *POINTS)).reshape(-1, *(1,) * car.x.ndim) * (POINT_SPACING / ROUTE_SPACING)
    index = jnp.clip(jnp.round(car.along / ROUTE_SPACING + ahead).astype(jnp.int32), 0, table.shape[-2] - 1)
    return look_up_row(table, scenario.map, scenario.route, index)


def _hidden_sides(moment: Moment) -> Sequence[Array]:
    """Return 1 for each place beyond a kerb beside the route ahead that is hidden, or out of the range of sight.

    The nearest point of the route comes first, and its right side before its left one.
    """
    world, car = moment.world, moment.state.vehicle
    if moment.state.perceived is None:
        return (jnp.zeros((2 * len(POINTS), *car.x.shape)),)
    right_x, right_y, left_x, left_y, _ = beside_the_route(moment)[:, 1:]
    x, y = (jnp.stack(sides, axis=1).reshape(-1, *car.x.shape) for sides in ((right_x, left_x), (right_y, left_y)))
    return (~in_sight(world, moment.scenario, car, x, y),)


def _next_crosswalk(moment: Moment) -> Sequence[Array]:
    """Return how far along the route the next crosswalk is."""
    if moment.state.perceived is None:
        return (jnp.ones(moment.state.step.shape),)
    return (beside_the_route(moment)[-1, 0] / FARTHEST,)


LAST_SEEN = Feature(
    "last_seen", 5 * NEIGHBOURS, _last_seen_bounds, _last_seen, (*PERSON_UNITS, f"just now (0: {KEPT:g} s ago)")
)
"""Who was last seen."""
HIDDEN_SIDES = Feature("hidden_sides", 2 * len(POINTS), share, _hidden_sides, FLAG)
"""Where the sides of the car's way are hidden."""
NEXT_CROSSWALK = Feature("next_crosswalk", 1, share, _next_crosswalk, (f"{FARTHEST:g} m",))
"""How far ahead the next crosswalk is."""
