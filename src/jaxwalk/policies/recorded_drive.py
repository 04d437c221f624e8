"""A car that drives where a recording says: it is where the recorded one was at every step, as far as it can be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Key

from jaxwalk.interfaces import Moment, View
from jaxwalk.sim.sim_config import SimConfig

SHORTEST_STEP = 1e-3
"""A car whose next place is nearer than this keeps its wheels straight [m]."""


class CarNow(NamedTuple):
    """Where the car is."""

    step: Int[Array, "*batch"]
    x: Float[Array, "*batch"]
    y: Float[Array, "*batch"]
    cos: Float[Array, "*batch"]
    sin: Float[Array, "*batch"]
    speed: Float[Array, "*batch"]


@dataclass(frozen=True)
class OwnPlace:
    """A view: where the car is."""

    name: str = "own place"
    """Its name in results."""

    def __call__(self, moment: Moment) -> CarNow:
        """Return where the car is at a moment."""
        car = moment.state.vehicle
        return CarNow(moment.state.step, car.x, car.y, car.cos, car.sin, car.speed)


class RecordedDrive(eqx.Module):
    """Drives from place to place: the bicycle of the simulator, solved for the action that leads to the next one.

    That holds for steps of one part (`SimConfig.substeps`): the car moves straight on at its slip, as far as its speed
    after the step says. Errors of a place die out, since the next step starts from where the car is.
    """

    t: Float[Array, "point"]
    """Times [s]."""
    x: Float[Array, "point"]
    """Places of the centre [m]."""
    y: Float[Array, "point"]
    rules: SimConfig = eqx.field(static=True)
    """The rules of the world in which it drives."""
    view: View = eqx.field(static=True, default=OwnPlace())
    """What it sees."""

    @classmethod
    def of(cls, t: np.ndarray, places: Float[np.ndarray, "point 2"], rules: SimConfig) -> RecordedDrive:
        """Return the car that is at places [m] at times [s]."""
        times, x, y = jnp.asarray(np.stack([t, *places.T]), jnp.float32)
        return cls(times, x, y, rules)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(self, key: Key[Array, "*batch"], memory: None, seen: CarNow) -> tuple[Float[Array, "2 *batch"], None]:
        """Return the action that leads to the next place."""
        rules = self.rules
        ahead, left = self._seen_from(seen, (seen.step + 1) * rules.dt)
        way = jnp.hypot(ahead, left)
        slip = jnp.where(way > SHORTEST_STEP, jnp.arctan2(left, ahead), 0)
        acceleration = (jnp.where(ahead > 0, way, 0) / rules.dt - seen.speed) / rules.dt
        pedal = acceleration / jnp.where(acceleration < 0, rules.max_braking, rules.max_acceleration)
        steering = jnp.arctan(2 * jnp.tan(jnp.clip(slip, -0.5, 0.5))) / rules.max_steering
        return jnp.clip(jnp.stack([pedal, steering]), -1, 1), memory

    def _seen_from(self, car: CarNow, time: Float[Array, "*batch"]) -> tuple[Array, Array]:
        """Return where the recorded car is at a time, ahead of the car and to its left [m]."""
        dx, dy = jnp.interp(time, self.t, self.x) - car.x, jnp.interp(time, self.t, self.y) - car.y
        return dx * car.cos + dy * car.sin, dy * car.cos - dx * car.sin
