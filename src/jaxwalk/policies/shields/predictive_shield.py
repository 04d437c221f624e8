"""The predictive shield: after every action the car could still brake clear of wherever people may be by then."""

from __future__ import annotations

import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.interfaces import View
from jaxwalk.policies.shields.shield_scene import Around, ShieldScene, Verdict
from jaxwalk.sim import vehicle
from jaxwalk.sim.events import distance, to_rectangle
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.state import VehicleState

EVERYWHERE = 180.0
"""A cone that leaves nobody out [degrees]."""
ROUNDING = 0.01
"""Single precision rounds: distances are kept larger by this [m]."""


class PredictiveShield(eqx.Module):
    """Keeps an action if the car, braking fully after it, touches nobody before it stands, whatever people do.

    After t s, each perceived person may be anywhere within ``reach_speed`` x t of where they are. The car brakes on
    with the action's steering, by the simulator's own step, kerbs included. Otherwise it brakes fully with the last
    step's steering: the step before has made sure of that. So while its assumption holds, the moving car touches
    nobody.
    """

    reach_speed: float = eqx.field(static=True, default=SimConfig.fastest_walk)
    """Nobody is faster than this [m/s]: the assumption."""
    cone: float = eqx.field(static=True, default=EVERYWHERE)
    """People further than this to the side of the car's heading are assumed to stay out of its way [degrees]."""
    view: View = eqx.field(static=True, default=Around())
    """What it sees."""

    def judge(self, action: Float[Array, "2 *batch"], scene: ShieldScene) -> Verdict:
        """Return whether braking after the action stays clear, and full braking as now steered."""
        held = scene.car.steering / scene.world.rules.max_steering
        braking = jnp.stack([-jnp.ones_like(held), held])
        safe = self._clear(action, scene)
        caught = jax.lax.cond(safe.all(), jnp.zeros_like, lambda _: ~self._clear(braking, scene), safe)
        return Verdict(safe, braking, caught & ~safe)

    def _clear(self, action: Float[Array, "2 *batch"], scene: ShieldScene) -> Bool[Array, "*batch"]:
        """Return whether the car stays clear if it does this, and then brakes until it stands."""
        braking = jnp.stack([-jnp.ones_like(action[0]), action[1]])
        steps = jnp.ones((), jnp.int32)

        def rolls_on(reached: tuple[Array, VehicleState, Array]) -> Array:
            _, car, clear = reached
            return ((car.speed > 0) & clear).any()

        def brake(reached: tuple[Array, VehicleState, Array]) -> tuple[Array, VehicleState, Array]:
            steps, car, clear = reached
            car = vehicle.drive(scene.world, scene.scenario, car, braking)
            return steps + 1, car, clear & self._apart(steps + 1, car, scene)

        car = vehicle.drive(scene.world, scene.scenario, scene.car, action)
        return jax.lax.while_loop(rolls_on, brake, (steps, car, self._apart(steps, car, scene)))[2]

    def _apart(self, steps: Array, car: VehicleState, scene: ShieldScene) -> Bool[Array, "*batch"]:
        """Return whether nobody can touch the car where it is after some steps, or it stands there."""
        rules, now, people = scene.world.rules, scene.car, scene.people
        ahead, left = to_frame(car.x - now.x, car.y - now.y, now.cos, now.sin)
        cos, sin = to_frame(car.cos, car.sin, now.cos, now.sin)
        place = to_frame(people.ahead - ahead, people.left - left, cos, sin)
        if rules.contact == "footprint":
            room = to_rectangle(*place, rules.car_length, rules.car_width) - rules.body_radius
        else:
            room = distance(*place) - rules.collision_distance
        clear = room >= self.reach_speed * rules.dt * steps + ROUNDING
        if self.cone < EVERYWHERE:
            away = distance(people.ahead, people.left)
            clear |= people.ahead < away * math.cos(math.radians(self.cone))
        return clear.all(axis=0) | (car.speed <= 0)
