"""What people at the kerb judge: who decides, how far away the car is, and how fast; and what they draw."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.interfaces import View
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import Observation, part
from jaxwalk.sim.pedestrian_features import KERB_CAR_DISTANCE

SET = "kerb"
KERB_VIEW: View = Observation("pedestrian", SET)
"""The view that `kerb_gap` reads."""
STANDS = 0.5
"""A car below this speed lets people go first [m/s]."""

Column = Float[Array, "ped *batch"]


class KerbGap(NamedTuple):
    """The gap that each pedestrian sees; arrays ``(ped, *batch)``."""

    deciding: Bool[Array, "ped *batch"]
    """At the kerb, on the way into the roadway, with the car near and not yet past."""
    ahead: Column
    """How far the car has to drive until it is where the pedestrian is [m]; below 0 once it has passed."""
    left: Column
    """Distance from the car's line of travel [m], positive to its left."""
    speed: Column
    """The car's speed [m/s]."""


def kerb_gap(observation: Float[Array, "feature ped *batch"]) -> KerbGap:
    """Return the gaps that the observation set "kerb" shows."""
    ahead, left = observation[part("pedestrian", SET, "place")] * KERB_CAR_DISTANCE
    speed = observation[part("pedestrian", SET, "car_motion")][0] * SPEED
    return KerbGap(observation[part("pedestrian", SET, "decides")][0] > 0, ahead, left, speed)


def drawn(key: Key[Array, "*batch"], one: Callable[[Key[Array, ""]], Array]) -> Array:
    """Return what ``one`` draws for each episode from its own key, with the episodes' axes last."""
    for _ in range(key.ndim):
        one = jax.vmap(one, out_axes=-1)
    return one(key)
