"""Infer a pedestrian's jaywalking tendency tau from watching it: Bayes' rule.

The prior of tau is uniform in [0, 1]. Every crossing is a jaywalk with probability min(1, multiplier x tau) (equation
1), independently of the others. The watcher sees everybody all the time and knows the multiplier, so no car could know
more from crossings alone.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Real

from jaxwalk.sim.crossing_kind import NO_CROSSING
from jaxwalk.sim.lookup import look_up
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState
from jaxwalk.sim.world import World

PRIOR_MEAN = 0.5
"""The mean of tau for somebody who has not crossed yet."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(32)
"""Gauss-Legendre quadrature on [-1, 1]: exact for polynomials of degree 63, so for 61 crossings."""
CROSSED = 1.0
"""A pedestrian off the roadway has crossed it if its path entered it more than this ago [m]: more than rounding."""


def posterior(
    jaywalks: Real[Array, "..."], crosswalks: Real[Array, "..."], multiplier: Float[Array, ""]
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Return mean and standard deviation of tau after a number of jaywalks and of crossings on a crosswalk.

    The density is proportional to p^jaywalks (1 - p)^crosswalks with p = min(1, multiplier x tau). Up to where p
    reaches 1 it is a polynomial; from there on it is constant, and 0 if there were crosswalk crossings. (With
    multiplier 0 it is the limit for small ones.)
    """
    jaywalks, crosswalks = jnp.broadcast_arrays(jaywalks, crosswalks)
    shape = (-1, *(1,) * jaywalks.ndim)
    share, weight = jnp.asarray((1 + NODES) / 2).reshape(shape), jnp.asarray(WEIGHTS / 2).reshape(shape)
    certain = 1 / jnp.maximum(multiplier, 1)  # the tau from which every crossing is a jaywalk
    likelihood = weight * share**jaywalks * (1 - jnp.minimum(multiplier, 1) * share) ** crosswalks

    def moment(power: int) -> Array:
        below = certain * (likelihood * (certain * share) ** power).sum(axis=0)
        above = (1 - certain ** (power + 1)) / (power + 1)
        return below + jnp.where(crosswalks == 0, above, 0)

    mean = moment(1) / moment(0)
    return mean, jnp.sqrt(moment(2) / moment(0) - mean * mean)


def crossings_seen(
    world: World, scenario: Scenario, people: PedestrianState
) -> tuple[Int[Array, "ped *batch"], Int[Array, "ped *batch"]]:
    """Return how many times each pedestrian has jaywalked and used a crosswalk so far: (jaywalks, crosswalks).

    A crossing counts from the first moment on the roadway: neither while it is only decided, nor on the way along the
    kerb to where a jaywalk will begin. Nothing has to be remembered, because the scenario says how crossing i was
    decided.
    """
    entered = people.on_roadway | (people.to_kerb < -CROSSED)
    intended = (people.crossing != NO_CROSSING) & ~entered
    seen = people.decisions - intended
    number = jnp.arange(scenario.jaywalk_draw.shape[0]).reshape(-1, *(1,) * seen.ndim)
    jaywalk = scenario.jaywalks(world, scenario.jaywalk_draw)
    jaywalks = (jaywalk & (number < seen)).sum(axis=0)
    return jaywalks, seen - jaywalks


def expected_tendency(world: World, scenario: Scenario, people: PedestrianState) -> Float[Array, "ped *batch"]:
    """Return the posterior mean of everybody's tau, given their crossings so far.

    Counts are small, so the mean is computed for all possible counts, and then looked up.
    """
    return expected_after(world, scenario, *crossings_seen(world, scenario, people))


def expected_after(
    world: World, scenario: Scenario, jaywalks: Int[Array, "ped *batch"], crosswalks: Int[Array, "ped *batch"]
) -> Float[Array, "ped *batch"]:
    """Return the posterior mean of everybody's tau after these numbers of crossings."""
    count = jnp.arange(scenario.jaywalk_draw.shape[0] + 1)
    means, _ = posterior(count[:, None], count, world.jaywalk_multiplier)
    return look_up(means, jaywalks, crosswalks)
