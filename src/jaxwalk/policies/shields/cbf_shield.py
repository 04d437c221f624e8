"""The shield of a control barrier function: an action may use up only a share of what keeps the car from people."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.columns import apply_where
from jaxwalk.interfaces import View
from jaxwalk.policies.shields.shield_scene import Around, ShieldScene, Verdict
from jaxwalk.safety.bicycle import slip
from jaxwalk.safety.cbf import collision_cone, least_allowed
from jaxwalk.sim import vehicle
from jaxwalk.sim.events import distance
from jaxwalk.sim.everybody import for_everybody, for_nearest
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import Motion, VehicleState
from jaxwalk.sim.world import Rules

PEDALS, STEERINGS = 41, 21
"""The grid of actions: accelerations and steerings, evenly spread over [-1, 1]."""
PART = 32
"""The grid is searched for cars that need it, one part in 32 of all cars at once."""
WIDER = 1.05
"""The circle to keep out of is this much wider than the one in which bodies can touch."""
FEASIBLE = -1e-5
"""Single precision rounds: h may fall below what is allowed by this [m2/s]."""

Found = tuple[Float[Array, "..."], Float[Array, "..."]]
"""The smallest h, and the smallest h beyond what is allowed, of anybody [m2/s]."""


class CbfShield(eqx.Module):
    """Keeps an action after which h is at least (1 - gamma) h for everybody near; else takes the nearest such action.

    h is C3BF's (`jaxwalk.safety.cbf`). People are taken to keep their velocity for a step, and the car to be where the
    bicycle model brings it: kerbs are left out. If no action of the grid does, it takes the one with the largest h.
    """

    gamma: float = eqx.field(static=True, default=0.2)
    """The share of h that a step may use up."""
    within: float = eqx.field(static=True, default=20.0)
    """People further away than this don't count [m]; ours."""
    view: View = eqx.field(static=True, default=Around())
    """What it sees."""

    def judge(self, action: Float[Array, "2 *batch"], scene: ShieldScene) -> Verdict:
        """Return whether the action leaves enough of h, and the nearest action of the grid that does."""
        beyond = self._least(action, scene, for_everybody)[1]
        safe = beyond >= FEASIBLE
        asked = (action, scene.scenario, scene.car, scene.people)

        def nearest(asked: tuple[Array, Scenario, VehicleState, Motion]) -> tuple[Array, Array]:
            return self._nearest(asked[0], ShieldScene(scene.shared, *asked[1:]))

        instead, feasible = apply_where(nearest, asked, ~safe, PART)
        return Verdict(safe, instead, ~safe & ~feasible)

    def _nearest(self, action: Float[Array, "2 *batch"], scene: ShieldScene) -> tuple[Array, Array]:
        """Return the best action of the grid, and whether it leaves enough of h."""
        axes = (1,) * (action.ndim - 1)
        grid = jnp.stack(jnp.meshgrid(jnp.linspace(-1, 1, PEDALS), jnp.linspace(-1, 1, STEERINGS), indexing="ij"))
        grid = grid.reshape(2, -1, *axes)
        away = distance(scene.people.ahead, scene.people.left)
        nearest_first = partial(for_nearest, away=away, within=self.within)
        actions = jnp.broadcast_to(grid, (*grid.shape[:2], *action.shape[1:]))
        least, beyond = self._least(actions, scene, nearest_first)
        change = ((grid - action[:, None]) ** 2).sum(axis=0)
        feasible = beyond >= FEASIBLE
        nearest = jnp.where(feasible, change, jnp.inf).argmin(axis=0)
        best = jnp.where(feasible.any(axis=0), nearest, least.argmax(axis=0))
        return grid.reshape(2, -1)[:, best], feasible.any(axis=0)

    def _least(self, actions: Float[Array, "2 ..."], scene: ShieldScene, loop: Callable[..., Any]) -> Found:
        """Return the smallest h of anybody after an action, ``(*batch)``, or after many, ``(action, *batch)``.

        The ``loop`` over people is `for_everybody`, or `for_nearest` where it saves more than sorting people costs.
        """
        rules = scene.world.rules
        (vx, vy), (x, y), (after_vx, after_vy) = _moved(actions, scene)
        radius = WIDER * touching_radius(rules)
        begin = jnp.full(actions.shape[1:], jnp.inf)

        def compare(person: Motion, found: Found) -> Found:
            person = jax.tree.map(lambda column: column[0], person)
            w = person.ahead_speed - vx, person.left_speed - vy
            after_w = person.ahead_speed - after_vx, person.left_speed - after_vy
            now = collision_cone((person.ahead, person.left), w, radius)
            px, py = person.ahead + person.ahead_speed * rules.dt - x, person.left + person.left_speed * rules.dt - y
            after = collision_cone((px, py), after_w, radius)
            beyond = after - least_allowed(now, distance(*w), distance(*after_w), self.gamma)
            near = distance(person.ahead, person.left) <= self.within
            after, beyond = (jnp.where(near, h, jnp.inf) for h in (after, beyond))
            return jnp.minimum(found[0], after), jnp.minimum(found[1], beyond)

        return loop(scene.people, body=compare, begin=(begin, begin))


def _moved(actions: Float[Array, "2 ..."], scene: ShieldScene) -> tuple[tuple[Array, Array], ...]:
    """Return the car's velocity now, its place after an action and its velocity then, in its present frame."""
    rules, car = scene.world.rules, scene.car
    pedal, steering = jnp.clip(actions, -1, 1)
    acceleration = jnp.where(pedal < 0, rules.max_braking, rules.max_acceleration) * pedal
    top = jnp.maximum(vehicle.top_speed(scene.world, car), car.speed - rules.max_braking * rules.dt)
    speed = jnp.clip(car.speed + acceleration * rules.dt, 0, top)
    cos, sin = slip(rules.max_steering * steering)
    turn = speed * rules.dt * sin / (0.5 * rules.wheelbase)
    now_cos, now_sin = slip(car.steering)
    after = speed * (cos * jnp.cos(turn) - sin * jnp.sin(turn)), speed * (sin * jnp.cos(turn) + cos * jnp.sin(turn))
    way = speed * rules.dt
    return (car.speed * now_cos, car.speed * now_sin), (way * cos, way * sin), after


def touching_radius(rules: Rules) -> Array:
    """Return the smallest distance of centres at which car and body can't touch [m]."""
    if rules.contact == "disc":
        return rules.collision_distance
    return distance(rules.car_length, rules.car_width) / 2 + rules.body_radius
