"""The time that each route takes at full throttle if nobody could be touched: what a delay is measured against."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from jaxwalk.metrics import DELAY, Rows
from jaxwalk.metrics.delay import Unhindered
from jaxwalk.policies import RouteFollower
from jaxwalk.policies.pursuit import pursue
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.sim import vehicle
from jaxwalk.sim.environment import Street
from jaxwalk.sim.events import arrives
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.scenario import Scenario, without_people
from jaxwalk.sim.state import VehicleState
from jaxwalk.sim.world import World


def unhindered_times(street: Street) -> Float[np.ndarray, "map route"]:
    """Return the time from start to goal of the driver ``route-follower`` without people [s]; NaN if it doesn't arrive.

    That driver looks at nobody, so the time depends on map and route alone: no scenario has to be played again.
    """
    steps = np.asarray(_steps(street.world, with_limits(RouteFollower(), street.config)))
    rules = street.world.rules
    return np.where(steps <= rules.horizon, steps * rules.dt, np.nan)


def with_delay(rows: Rows, times: Float[np.ndarray, "map route"], scenarios: Scenario) -> Rows:
    """Return rows that know the unhindered time of each of their episodes, the first ones of ``scenarios``.

    Scripted episodes begin under way, so their times are unknown: NaN.
    """
    maps, routes = (np.asarray(x)[: rows.episodes] for x in (scenarios.map, scenarios.route))
    known = times[maps, routes]
    return rows.having(DELAY, Unhindered(known if scenarios.script is None else np.full_like(known, np.nan)))


@eqx.filter_jit
def _steps(world: World, follower: RouteFollower) -> Int[Array, "map route"]:
    """Return the step in which the car arrives on each route, or one beyond the horizon."""
    maps, routes = world.tables.finish.shape[:2]
    scenario = without_people(*jnp.indices((maps, routes)))
    goal_x, goal_y = vehicle.goal(world, scenario)
    never = world.rules.horizon + 1

    def under_way(progress: tuple[Array, Array, VehicleState]) -> Array:
        step, arrived, _ = progress
        return (step < world.rules.horizon) & (arrived == never).any()

    def drive(progress: tuple[Array, Array, VehicleState]) -> tuple[Array, Array, VehicleState]:
        step, arrived, car = progress
        car = vehicle.drive(world, scenario, car, _full_throttle(follower, car))
        there = arrives(car.x - goal_x, car.y - goal_y, world.rules.goal_distance)
        return step + 1, jnp.where(there, jnp.minimum(arrived, step + 1), arrived), car

    start = vehicle.place(world, scenario)
    nowhere = jnp.full((maps, routes), never)
    return jax.lax.while_loop(under_way, drive, (jnp.zeros((), int), nowhere, start))[1]


def _full_throttle(follower: RouteFollower, car: VehicleState) -> Float[Array, "2 map route"]:
    """Return what `RouteFollower` does here."""
    points = to_frame(car.course.ahead_x - car.x, car.course.ahead_y - car.y, car.cos, car.sin)
    shown = jnp.stack([coordinate[0] for coordinate in points]) / (POINTS[0] * POINT_SPACING)
    steering = pursue(shown, wheelbase=follower.wheelbase, max_steering=follower.max_steering)
    return jnp.stack([jnp.ones_like(steering), steering])
