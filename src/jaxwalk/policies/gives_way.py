"""People who give way to a car where its path is, also on the roadway: they slow down, and stand only at its edge.

So did people at a real crosswalk (``docs/real-recordings.md``). Which gaps they accept is fitted to every second clip
of it, by ``docs/real_recordings_calibration.py``; that they walk at half their pace meanwhile, and when they stand, are
ours.
"""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.gap_acceptance import critical_gaps
from jaxwalk.policies.kerb_gap import KERB_VIEW, SET, STANDS, Column, KerbGap, kerb_gap
from jaxwalk.policies.world_numbers import from_world
from jaxwalk.sim.observation import part

INTERCEPT, PER_SECOND = 4.33, 1.14
"""P(accept) = 1 / (1 + exp(4.33 - 1.14 gap)), gap in s: one half at 3.8 s."""
EDGE = 0.15
"""Nearer to the car's path than this, people who give way stand [m] ..."""
SOON = 1.0
"""... if the car's front is there within this time [s]."""


class GivingWay(NamedTuple):
    """What people remember; arrays ``(ped, *batch)``."""

    critical: Column
    """Critical gaps [s]."""
    steps: Int[Array, "ped *batch"]
    """For how many steps they have given way without a break."""


class GivesWay(eqx.Module):
    """Judges the car just before its path, at the kerb or on the roadway, and walks at half its pace to let it pass.

    The path is what the car covers straight on. Each approach to it has a critical gap of its own. Half a pace is every
    second step; people who reach the path's edge before the car has passed stand there. Nobody gives way to a car that
    stands.
    """

    intercept: float = eqx.field(static=True, default=INTERCEPT)
    """P(accept) = 1 / (1 + exp(intercept - per_second x gap)), gap in s."""
    per_second: float = eqx.field(static=True, default=PER_SECOND)
    """How fast gaps become more acceptable [1/s]."""
    car_length: float = from_world("car_length")
    car_width: float = from_world("car_width")
    body_radius: float = from_world("body_radius")
    kerb_distance: float = from_world("kerb_distance")
    """People judge the car this long a way before its path [m]."""
    view: View = eqx.field(static=True, default=KERB_VIEW)
    """What it sees."""

    @property
    def sample(self) -> bool:
        """Always True: it draws critical gaps."""
        return True

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> GivingWay:
        """Return critical gaps [s] that are drawn anew at the first step, since nobody begins before a car's path."""
        usual = jnp.full((*agents, *batch), self.intercept / self.per_second)
        return GivingWay(usual, jnp.zeros(usual.shape, jnp.int32))

    def act(
        self, key: Key[Array, "*batch"], memory: GivingWay, observation: Float[Array, "feature ped *batch"]
    ) -> tuple[Int[Array, "ped *batch"], GivingWay]:
        """Return who goes, and what people remember: a critical gap while they are before the path, else a new one."""
        gap = kerb_gap(observation)
        to_path = jnp.abs(gap.left) - self.car_width / 2 - self.body_radius
        judging = self._judging(gap, to_path, observation)
        drawn = critical_gaps(key, len(to_path), self.intercept, self.per_second)
        critical = jnp.where(judging, memory.critical, drawn)
        gives = judging & (gap.speed >= STANDS) & (gap.ahead < critical * gap.speed)
        steps = jnp.where(gives, memory.steps + 1, 0)
        stands = (to_path < EDGE) & (gap.ahead < self._reach + gap.speed * SOON)
        go = ~gives | ((steps % 2 == 0) & ~stands)
        return go.astype(jnp.int32), GivingWay(critical, steps)

    @property
    def _reach(self) -> float:
        """How far before and behind its centre the car touches somebody on its path [m]."""
        return self.car_length / 2 + self.body_radius

    def _judging(
        self, gap: KerbGap, to_path: Column, observation: Float[Array, "feature ped *batch"]
    ) -> Bool[Array, "ped *batch"]:
        """Return who is just before the path, on the way to it, and not yet passed by the car."""
        aside = observation[part("pedestrian", SET, "direction")][1]
        on_roadway = observation[part("pedestrian", SET, "to_kerb")][0] < 0
        toward = (gap.left * aside < 0) & (to_path > 0) & (to_path <= self.kerb_distance * jnp.abs(aside))
        return toward & (gap.deciding | on_roadway) & (gap.ahead > -self._reach)
