"""Infer a pedestrian's jaywalking tendency tau from watching it: Bayes' rule.

The prior of tau is the world's: uniform in [0, 1], or that of each kind of people with its share. Beside a jaywalk zone
every crossing is a jaywalk with probability min(1, multiplier x tau) (equation 1), independently of the others. Where
there is none, crossings tell nothing. The watcher knows prior and multiplier. Where everybody sees everybody it has
seen all crossings, so no car could know more from these alone; elsewhere it has seen those that its car perceived.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax.scipy.special import xlog1py, xlogy
from jaxtyping import Array, Float, Int, Real

from jaxwalk.sim.crossing_kind import NO_CROSSING
from jaxwalk.sim.lookup import look_up
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState
from jaxwalk.sim.world import World

NODES, WEIGHTS = np.polynomial.legendre.leggauss(32)
"""Gauss-Legendre quadrature on [-1, 1]: exact for polynomials of degree 63, so for 61 crossings."""
CROSSED = 1.0
"""A pedestrian off the roadway has crossed it if its path entered it more than this ago [m]: more than rounding."""


def posterior(
    jaywalks: Real[Array, "..."], crosswalks: Real[Array, "..."], multiplier: Float[Array, ""]
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Return mean and standard deviation of a uniform tau after numbers of jaywalks and of crossings on a crosswalk.

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


def mean_of_kinds(world: World, jaywalks: Real[Array, "..."], crosswalks: Real[Array, "..."]) -> Float[Array, "..."]:
    """Return the mean of tau after these numbers of crossings, where it is that of one of several kinds of people.

    Likelihoods are compared as logarithms, so that many crossings don't underflow. Where somebody did what nobody of
    any kind would ever do, the prior stays.
    """
    taus, shares = (x.reshape(-1, *(1,) * jaywalks.ndim) for x in _kinds(world))
    chance = jnp.minimum(1, world.rules.jaywalk_multiplier * taus)
    evidence = jnp.log(shares) + xlogy(jaywalks, chance) + xlog1py(crosswalks, -chance)
    most = evidence.max(axis=0)
    weight = jnp.where(most == -jnp.inf, shares, jnp.exp(evidence - jnp.where(most == -jnp.inf, 0, most)))
    return (weight * taus).sum(axis=0) / weight.sum(axis=0)


def prior_mean(world: World) -> float | Float[Array, ""]:
    """Return the mean of tau of somebody who has not crossed yet."""
    if not world.rules.kinds:
        return 0.5
    taus, shares = _kinds(world)
    return (taus * shares).sum()


def _kinds(world: World) -> tuple[Float[Array, " kind"], Float[Array, " kind"]]:
    """Return the tau and the share of each kind of people."""
    kinds = world.rules.kinds
    return jnp.array([kind.tendency for kind in kinds]), jnp.array([kind.share for kind in kinds])


def crossings_seen(
    world: World, scenario: Scenario, people: PedestrianState
) -> tuple[Int[Array, "ped *batch"], Int[Array, "ped *batch"]]:
    """Return how many times each pedestrian has jaywalked and used a crosswalk so far: (jaywalks, crosswalks).

    A crossing counts from the first moment on the roadway: neither while it is only decided, nor on the way along the
    kerb to where a jaywalk will begin. At a side without a jaywalk zone it counts as neither, as nobody had a choice.
    Nothing has to be remembered, because the scenario says how decision i was made.
    """
    entered = people.on_roadway | (people.to_kerb < -CROSSED)
    intended = (people.crossing != NO_CROSSING) & people.may_jaywalk & ~entered
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
    """Return the posterior mean of everybody's tau after these numbers of crossings, and what was seen earlier."""
    earlier = world.rules.earlier_decisions
    if earlier:
        known = scenario.earlier_jaywalks(world)
        jaywalks, crosswalks = jaywalks + known, crosswalks + earlier - known
    count = jnp.arange(scenario.jaywalk_draw.shape[0] + earlier + 1)
    if world.rules.kinds:
        means = mean_of_kinds(world, *jnp.broadcast_arrays(count[:, None], count))
    else:
        means, _ = posterior(count[:, None], count, world.rules.jaywalk_multiplier)
    return look_up(means, jaywalks, crosswalks)
