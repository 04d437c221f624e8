"""A driver that knows the future. It separates collisions that could have been avoided from those that could not.

It searches for the best speeds along its route by dynamic programming over time, place and speed. A manoeuvre (brake,
hold or accelerate) lasts 0.6 s and changes the speed by at most one level. So it always ends at a place and a moment
that the observation set shows: from level k to level k + a, the car drives 2k + a places of 0.5 m. It plans to brake as
gently as it accelerates, also a car that could brake harder.
"""

from __future__ import annotations

from functools import reduce

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.pursuit import pursue
from jaxwalk.policies.world_numbers import from_world
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.future import MOMENTS, PLACES, SPACING, STEPS
from jaxwalk.sim.manoeuvres import FAR
from jaxwalk.sim.observation import PRIVILEGED, Observation, part
from jaxwalk.sim.prediction import DISTANCE
from jaxwalk.sim.sim_config import ContactRule, SimConfig

LEVEL = SimConfig.max_speed / 5
"""Difference between neighbouring speeds, the levels [m/s]: 6 of them up to 8.33 m/s, 9 up to 13.9 m/s."""
HELD = 6
"""Steps that a manoeuvre lasts."""
DURATION = HELD * SimConfig.dt
"""Time that a manoeuvre lasts [s]. LEVEL / DURATION is 2.8 m/s2, and LEVEL x DURATION is two places."""
SEEN = HELD // STEPS
"""Moments at which the future is shown during a manoeuvre."""
ARRIVED = SimConfig.goal_distance - 0.1
"""With this much of the route left, the car has arrived [m]."""
MARGIN = 0.4
"""Safety margin [m], beyond the distance of a contact: the car leaves its route by up to 0.35 m in a turn."""
COMFORT = 1.5
"""Comfortable margin [m]: more has no value. People on the sidewalk pass the middle of the lane at 3 m."""
MARGIN_COST, COMFORT_COST = 1000.0, 1.0
"""Cost at each moment of each metre inside the margin [s/m], and of each square metre inside the comfortable distance
[s/m2]."""
TOO_FAST = 10.0
"""Cost of a manoeuvre that ends faster than the limit there [s]: the car would be slower, and not where it plans."""
ROUNDING = 0.01
"""A level is within the limit if it is no more than this above it [m/s]."""

Memory = tuple[Float[Array, "*batch"], Int[Array, "*batch"]]
"""The current acceleration, as a share of the largest, and the number of steps for which it still holds."""


class Oracle(eqx.Module):
    """Drives along its lane route as fast as the future allows, if everybody walks on (pure pursuit, 2.5 m ahead).

    It minimises the time to the goal plus the cost of closeness over the next 9.6 s, drives the first manoeuvre
    (0.6 s) and plans again. If people may wait, the future that it observes is only a guess.
    """

    max_speed: float = from_world("max_speed")
    """The car's top speed [m/s]."""
    max_acceleration: float = from_world("max_acceleration")
    """Its largest acceleration [m/s2]."""
    max_braking: float = from_world("max_braking")
    """Its largest braking [m/s2]."""
    contact: ContactRule = from_world("contact")
    """What counts as a contact, by which the future is shown."""
    collision_distance: float = from_world("collision_distance")
    """Centres closer than this collide by ``disc`` [m]."""
    body_radius: float = from_world("body_radius")
    """Radius of a pedestrian's body, which collides with the car's rectangle by ``footprint`` [m]."""
    wheelbase: float = from_world("wheelbase")
    """Distance between the car's axles [m]."""
    max_steering: float = from_world("max_steering")
    """The car's largest steering angle [rad]."""
    view: View = eqx.field(static=True, default=Observation("driver", PRIVILEGED))
    """What it sees."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Memory:
        """Return a memory that holds no manoeuvre yet."""
        return jnp.zeros((*agents, *batch)), jnp.zeros((*agents, *batch), jnp.int32)

    def act(
        self, key: Key[Array, "*batch"], memory: Memory, observation: Float[Array, "feature *batch"]
    ) -> tuple[Float[Array, "2 *batch"], Memory]:
        """Continue the current manoeuvre, or plan a new one."""
        held, left = memory
        plan = jax.lax.cond((left == 0).any(), self._best_acceleration, lambda _: held, observation)
        acceleration = jnp.where(left == 0, plan, held)
        route = observation[part("driver", PRIVILEGED, "route")]
        steering = pursue(route, wheelbase=self.wheelbase, max_steering=self.max_steering)
        return jnp.stack([acceleration, steering]), (acceleration, jnp.where(left == 0, HELD, left) - 1)

    def _best_acceleration(self, observation: Float[Array, "feature *batch"]) -> Float[Array, "*batch"]:
        """Return the acceleration of the best plan's first manoeuvre, as a share of the largest, or of the braking."""
        speed = observation[part("driver", PRIVILEGED, "speed")][0] * SPEED
        to_go = observation[part("driver", PRIVILEGED, "to_go")][0] * DISTANCE
        clearances = observation[part("driver", PRIVILEGED, "clearances")] * FAR
        limits = observation[part("driver", PRIVILEGED, "limits")] * SPEED
        levels = 1 + int((self.max_speed + ROUNDING) / LEVEL)
        level = jnp.clip(jnp.round(speed / LEVEL).astype(jnp.int32), 0, levels - 1)
        touching = self.collision_distance if self.contact == "disc" else self.body_radius
        closeness = _closeness(clearances.reshape(MOMENTS, PLACES, *speed.shape), touching)
        rest = _time_to_goal(to_go, levels, self.max_speed)
        change = _plan(closeness, _arrived(to_go), _too_fast(limits, levels), rest)
        gained = (level + jnp.take_along_axis(change, level[None], axis=0)[0]) * LEVEL - speed
        largest = jnp.where(gained < 0, DURATION * self.max_braking, DURATION * self.max_acceleration)
        return jnp.clip(gained / largest, -1, 1)


def _closeness(clearances: Float[Array, "moment place *batch"], touching: float) -> Float[Array, "moment place *batch"]:
    """Return the cost of being anywhere between a place and the next one at a moment [s].

    A clearance below ``touching`` [m] is a contact.
    """
    margin, comfort = touching + MARGIN, touching + COMFORT
    nearest = jnp.minimum(clearances[:, :-1], clearances[:, 1:])
    nearest = jnp.concatenate([nearest, clearances[:, -1:]], axis=1)
    return MARGIN_COST * jnp.maximum(margin - nearest, 0) + COMFORT_COST * jnp.maximum(comfort - nearest, 0) ** 2


def _arrived(to_go: Float[Array, "*batch"]) -> Bool[Array, "place *batch"]:
    """Return at which places the car has arrived."""
    return jnp.arange(PLACES).reshape(-1, *(1,) * to_go.ndim) * SPACING >= to_go - ARRIVED


def _too_fast(limits: Float[Array, "place *batch"], levels: int) -> Float[Array, "level place *batch"]:
    """Return the cost of being at a place with the speed of a level [s]."""
    speed = (LEVEL * jnp.arange(levels)).reshape(-1, *(1,) * limits.ndim)
    return jnp.where(speed > limits + ROUNDING, TOO_FAST, 0.0)


def _plan(
    closeness: Float[Array, "moment place *batch"],
    arrived: Bool[Array, "place *batch"],
    too_fast: Float[Array, "level place *batch"],
    rest: Float[Array, "level place *batch"],
) -> Int[Array, "level *batch"]:
    """Return the best change of level now, for each level, by going backwards from the end of the horizon.

    ``cost[level, place]`` is the time to the goal from there plus the cost of closeness on the way [s]; it begins with
    the time for the ``rest`` of the way.
    """
    levels = len(rest)

    def earlier(cost: Array, closeness: Array) -> tuple[Array, Array]:
        cost, closeness = _extended(cost + too_fast, levels), _extended(closeness, levels)
        least, change = zip(*(_choose(cost, closeness, level, levels) for level in range(levels)), strict=True)
        return jnp.where(arrived, 0, jnp.stack(least)), jnp.stack(change)

    by_manoeuvre = closeness.reshape(-1, SEEN, *closeness.shape[1:])
    return jax.lax.scan(earlier, rest, by_manoeuvre, reverse=True)[1][0]


def _choose(
    cost: Array, closeness: Array, level: int, levels: int
) -> tuple[Float[Array, "place *batch"], Int[Array, "*batch"]]:
    """Return the least cost from each place at a level, and the change of level that is best at the car's own place."""
    changes = [change for change in (1, 0, -1) if 0 <= level + change < levels]  # the fastest wins a tie
    choices = [_cost_of(cost, closeness, level, change) for change in changes]
    best = jnp.stack([choice[0] for choice in choices]).argmin(axis=0)
    return reduce(jnp.minimum, choices), jnp.array(changes)[best]


def _cost_of(cost: Array, closeness: Array, level: int, change: int) -> Float[Array, "place *batch"]:
    """Return a manoeuvre's cost from each place: its time, closeness at each moment, and the cost from its end."""
    share = np.arange(1, SEEN + 1) / SEEN
    driven = (
        2 * level * share + change * share**2 + change * share / HELD
    )  # the last term: a step changes the speed first
    close = sum(closeness[i, place : place + PLACES] for i, place in enumerate(np.maximum(driven, 0).astype(int)))
    end = 2 * level + change
    return DURATION + close + cost[level + change, end : end + PLACES]


def _extended(table: Float[Array, "row place *batch"], levels: int) -> Float[Array, "row farther *batch"]:
    """Repeat the last place as far as a manoeuvre can take the car beyond it."""
    return jnp.pad(table, [(0, 0), (0, 2 * levels)] + [(0, 0)] * (table.ndim - 2), mode="edge")


def _time_to_goal(to_go: Float[Array, "*batch"], levels: int, top: float) -> Float[Array, "level place *batch"]:
    """Return the cost at the end of the horizon: the time for the rest of the way at top speed [s], at every level.

    If speed had a value there, it would pay to fall back now and to accelerate into the unknown.
    """
    distance = to_go - ARRIVED - (jnp.arange(PLACES) * SPACING).reshape(-1, *(1,) * to_go.ndim)
    return jnp.broadcast_to(jnp.maximum(distance, 0) / top, (levels, *distance.shape))
