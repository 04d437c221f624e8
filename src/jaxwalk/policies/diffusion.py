"""People who gather evidence at the kerb until it suffices to cross: variable-drift diffusion (Pekkanen et al., 2022).

"Variable-drift diffusion models of pedestrian road-crossing decisions", Computational Brain & Behavior,
doi 10.1007/s42113-021-00116-z; the numbers are those of the authors' repository, fitted in virtual reality. A moving
car is tau = distance / speed away. What counts is an apparent time

    tau' = tau + 0.752 (distance / 13.89 - tau) + 0.585 (dtau/dt + 1)

so that people also judge by distance, and see braking. Evidence A drifts by atan(0.587 (tau' - 1.637)), or by pi / 2 if
the car stands or has passed, leaks, and is noisy: dA = (drift - 1.844 A) dt + 0.641 dW. A person crosses at A = 0.840.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.kerb_gap import KERB_VIEW, STANDS, Column, drawn, kerb_gap
from jaxwalk.policies.world_numbers import from_world

BY_DISTANCE, BY_BRAKING = 0.752, 0.585
"""Weights of distance and of braking in the apparent time."""
USUAL_SPEED = 13.89
"""Speed at which people would read a time from a distance [m/s]."""
STEEPNESS, MIDDLE = 0.587, 1.637
"""Steepness [1/s] of the drift, and the apparent time at which it is 0 [s]."""
LEAK, NOISE, THRESHOLD = 1.844, 0.641, 0.840
"""Leak of evidence [1/s], its noise [1/sqrt(s)], and the evidence that suffices."""
PASSED_FOR = 0.143
"""A car has passed when it was at the pedestrian's place this long ago [s]."""
SUBSTEP = 1 / 30
"""Time step of the source [s]. Steps of 0.1 s would lower the shares of crossings at 5 and 6 s by 0.03 to 0.05."""


class Apparent(NamedTuple):
    """What evidence comes from; arrays ``(ped, *batch)``."""

    ahead: Column
    """Distance of the car [m], below 0 once it has passed."""
    speed: Column
    """Its speed [m/s]."""
    acceleration: Column
    """Its acceleration [m/s2]."""


class Gathered(NamedTuple):
    """What people remember; arrays ``(ped, *batch)``."""

    evidence: Column
    """Evidence for crossing; 0 on arrival at a kerb."""
    speed: Column
    """The car's speed one step before [m/s]; below 0 before the first step."""


class Diffusion(eqx.Module):
    """Waits at the kerb until enough evidence has come together that the gap is safe, or that the car yields.

    Who has decided to cross goes. People also go if the car is more than 40 m away (67 m in the world ``town``), and
    always on the roadway. Source and equation are in the module `jaxwalk.policies.diffusion`.
    """

    dt: float = from_world("dt")
    """Duration of a step [s]; evidence grows in parts of about 1/30 s."""
    view: View = eqx.field(static=True, default=KERB_VIEW)
    """What it sees."""

    @property
    def sample(self) -> bool:
        """Always True: evidence is noisy."""
        return True

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Gathered:
        """Return no evidence, and no speed yet."""
        return Gathered(jnp.zeros((*agents, *batch)), jnp.full((*agents, *batch), -1.0))

    def act(
        self, key: Key[Array, "*batch"], memory: Gathered, observation: Float[Array, "feature ped *batch"]
    ) -> tuple[Int[Array, "ped *batch"], Gathered]:
        """Return who goes, and the evidence of those who are at a kerb."""
        gap = kerb_gap(observation)
        apparent = Apparent(gap.ahead, gap.speed, acceleration(memory, gap.speed, self.dt))
        evidence = jnp.where(gap.deciding, gather(key, memory.evidence, apparent, self.dt), 0)
        go = ~gap.deciding | (evidence >= THRESHOLD)
        return go.astype(jnp.int32), Gathered(evidence, gap.speed)


def acceleration(memory: Gathered, speed: Column, dt: float) -> Column:
    """Return the car's acceleration since the last step [m/s2]; 0 in the first one."""
    return jnp.where(memory.speed < 0, 0, (speed - memory.speed) / dt)


def gather(key: Key[Array, "*batch"], evidence: Column, apparent: Apparent, dt: float) -> Column:
    """Return the evidence after a step of ``dt`` seconds. Who has enough keeps it: a decision stands."""
    parts = max(1, round(dt / SUBSTEP))
    step = dt / parts
    noise = drawn(key, lambda one: jax.random.normal(one, (parts, len(evidence))))
    for part in range(parts):
        change = step * (drift(apparent, part * step) - LEAK * evidence) + NOISE * math.sqrt(step) * noise[part]
        evidence = jnp.where(evidence < THRESHOLD, evidence + change, evidence)
    return evidence


def drift(apparent: Apparent, later: float = 0.0) -> Float[Array, "ped *batch"]:
    """Return the drift of evidence [1/s] ``later`` seconds on, if the car keeps its speed meanwhile.

    At constant acceleration a, dtau/dt + 1 = -distance x a / speed^2.
    """
    speed = jnp.maximum(apparent.speed, STANDS)
    distance = apparent.ahead - speed * later
    time = distance / speed
    slowing = -distance * apparent.acceleration / speed**2
    seems = time + BY_DISTANCE * (distance / USUAL_SPEED - time) + BY_BRAKING * slowing
    free = (apparent.speed < STANDS) | (time < -PASSED_FOR)
    return jnp.where(free, math.pi / 2, jnp.arctan(STEEPNESS * (seems - MIDDLE)))
