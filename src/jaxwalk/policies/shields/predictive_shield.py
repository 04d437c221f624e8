"""The predictive shield: after every action the car could still brake clear of wherever people may be by then."""

from __future__ import annotations

import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.columns import apply_where
from jaxwalk.interfaces import View
from jaxwalk.policies.shields.shield_scene import Around, ShieldScene, Verdict
from jaxwalk.sim import vehicle
from jaxwalk.sim.events import distance, to_rectangle
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.state import Motion, VehicleState

ROUNDING = 0.01
"""Single precision rounds: distances are kept larger by this [m]."""
PART = 8
"""Cars that may touch somebody are looked at again, one part in 8 of all cars at a time."""


class PredictiveShield(eqx.Module):
    """Keeps an action if the car, braking fully after it, touches nobody before it stands, whatever people do.

    After t s, each perceived person may be anywhere within ``reach_speed`` x t of where they are, as far as that is
    also within what ``acceleration`` allows of where they would be had they kept their velocity: the two sets of
    Koschi, Pek, Beikirch and Althoff 2018 for a pedestrian's dynamics, with our numbers. The car brakes on with the
    action's steering, by the simulator's own step, kerbs included. Otherwise it brakes fully with the last step's
    steering: the step before has made sure of that. So while its assumption holds, the moving car touches nobody.
    """

    reach_speed: float = eqx.field(static=True, default=SimConfig.fastest_walk)
    """Nobody is faster than this [m/s]: the assumption."""
    acceleration: float = eqx.field(static=True, default=math.inf)
    """Nobody changes their velocity faster than this, in any direction [m/s2]: the other assumption."""
    view: View = eqx.field(static=True, default=Around())
    """What it sees."""

    def judge(self, action: Float[Array, "2 *batch"], scene: ShieldScene) -> Verdict:
        """Return whether braking after the action stays clear, and full braking as now steered."""
        held = scene.car.steering / scene.world.rules.max_steering
        braking = jnp.stack([-jnp.ones_like(held), held])
        safe = self._clear(action, scene, math.inf)
        if math.isfinite(self.acceleration):
            safe |= self._clear_where(~safe, action, scene)
        return Verdict(safe, braking, ~safe & ~self._clear_where(~safe, braking, scene))

    def _clear_where(
        self, which: Bool[Array, "*batch"], action: Float[Array, "2 *batch"], scene: ShieldScene
    ) -> Bool[Array, "*batch"]:
        """Return whether the cars asked about stay clear by the shield's own assumptions; False for all others."""

        def clear(asked: tuple[Array, Scenario, VehicleState, Motion]) -> Array:
            return self._clear(asked[0], ShieldScene(scene.shared, *asked[1:]), self.acceleration)

        return apply_where(clear, (action, scene.scenario, scene.car, scene.people), which, PART)

    def _clear(
        self, action: Float[Array, "2 *batch"], scene: ShieldScene, acceleration: float
    ) -> Bool[Array, "*batch"]:
        """Return whether the car stays clear if it does this, and then brakes until it stands.

        Nobody changes their velocity faster than by the ``acceleration`` [m/s2].
        """
        braking = jnp.stack([-jnp.ones_like(action[0]), action[1]])
        steps = jnp.ones((), jnp.int32)

        def rolls_on(reached: tuple[Array, VehicleState, Array]) -> Array:
            _, car, clear = reached
            return ((car.speed > 0) & clear).any()

        def brake(reached: tuple[Array, VehicleState, Array]) -> tuple[Array, VehicleState, Array]:
            steps, car, clear = reached
            car = vehicle.drive(scene.world, scene.scenario, car, braking)
            return steps + 1, car, clear & self._apart(steps + 1, car, scene, acceleration)

        car = vehicle.drive(scene.world, scene.scenario, scene.car, action)
        return jax.lax.while_loop(rolls_on, brake, (steps, car, self._apart(steps, car, scene, acceleration)))[2]

    def _apart(self, steps: Array, car: VehicleState, scene: ShieldScene, acceleration: float) -> Bool[Array, "*batch"]:
        """Return whether nobody can touch the car where it is after some steps, or it stands there; as for `_clear`."""
        time = scene.world.rules.dt * steps
        clear = _room(scene, car, (scene.people.ahead, scene.people.left)) >= self.reach_speed * time + ROUNDING
        if math.isfinite(acceleration):
            gained = acceleration * time * (time + scene.world.rules.dt) / 2  # velocities change once a step
            clear |= _room(scene, car, scene.people.at(time)) >= gained + ROUNDING
        return clear.all(axis=0) | (car.speed <= 0)


def _room(scene: ShieldScene, car: VehicleState, people: tuple[Array, Array]) -> Float[Array, "_ *batch"]:
    """Return how far places, ahead and left of where the car is now, are from touching it where it is then [m]."""
    rules, now = scene.world.rules, scene.car
    ahead, left = to_frame(car.x - now.x, car.y - now.y, now.cos, now.sin)
    cos, sin = to_frame(car.cos, car.sin, now.cos, now.sin)
    place = to_frame(people[0] - ahead, people[1] - left, cos, sin)
    if rules.contact == "footprint":
        return to_rectangle(*place, rules.car_length, rules.car_width) - rules.body_radius
    return distance(*place) - rules.collision_distance
