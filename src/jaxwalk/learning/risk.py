"""Limits of costs: what a step is charged, the multiplier of each limit, and the advantage that they make.

``docs/learning.md#limits`` says why it is done this way.
"""

from __future__ import annotations

from collections.abc import Iterable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.acting import part_of
from jaxwalk.interfaces import Environment
from jaxwalk.learning.casting import Shard
from jaxwalk.learning.config import CostLimit, TrainConfig
from jaxwalk.learning.monitor import by_agent
from jaxwalk.rollout import Step, draw_batch
from jaxwalk.shards import SHARDS, Axis

SMOOTHING = 0.95
"""Weight of the past in the controller's moving averages (OmniSafe, CPPOPID.yaml)."""
DELAY = 10
"""The cost's rise is that since this number of updates (OmniSafe, CPPOPID.yaml)."""
MOST = 2.0
"""Costs above this many times the limit count as this many times it. So the controller's error lies in [-1, 1], and it
winds up no faster than it unwinds (ours: OmniSafe's costs and limit are of like size)."""
THRESHOLD_STEP = 0.05
"""Largest step of a tail's threshold in an update, as a share of the limit (ours)."""


class Multiplier(eqx.Module):
    """The multiplier of a limit, and the state of the controller that sets it. Costs are in units of the limit."""

    value: Float[Array, ""]
    """Lambda, 0 or more: how many times a unit of the cost is worth `CostLimit.worth`."""
    integral: Float[Array, ""]
    """The sum of errors times its gain, never below 0."""
    error: Float[Array, ""]
    """Moving average of the excess over the limit."""
    cost: Float[Array, ""]
    """Moving average of the cost ..."""
    earlier: Float[Array, " delay"]
    """... and those of the last `DELAY` updates, oldest first."""
    threshold: Float[Array, ""]
    """With a tail: the cost that a share 1 - tail of the episodes exceeds (the value at risk), in units of the cost."""


def fresh_multipliers(config: TrainConfig) -> dict[str, Multiplier]:
    """Return the multipliers of an untrained learner, by the names of `TrainConfig.limits`: all numbers are 0."""
    zero = jnp.zeros((), jnp.float32)
    multiplier = Multiplier(zero, zero, zero, zero, jnp.zeros(DELAY, jnp.float32), zero)
    return dict.fromkeys(config.limits, multiplier)


def check_costs(environment: Environment, config: TrainConfig) -> None:
    """Raise ValueError unless the environment counts every cost that has a limit. Computes nothing."""
    if not config.limits:
        return

    def step() -> dict[str, dict[str, Array]]:
        scenario = draw_batch(environment, jax.random.split(jax.random.key(0), 1))
        still = {role: spec.zeros((1,)) for role, spec in environment.roles.items()}
        return environment.step(scenario, environment.reset(scenario), still)[1].costs

    costs = eqx.filter_eval_shape(step)
    for role, limit in config.limits.values():
        known = costs.get(role, {})
        if limit.cost not in known:
            raise ValueError(f"limits: the {role} has no cost {limit.cost!r}; there are: {', '.join(known) or 'none'}")


def constrained(
    advantage: Float[Array, "..."], of_costs: Iterable[tuple[Float[Array, ""], Float[Array, "..."]]]
) -> Float[Array, "..."]:
    """Return (A - sum of lambda A_c) / (1 + sum of lambda): Stooke 2020, section 5.2.

    ``of_costs`` holds lambda and A_c, the advantage of what is charged, for each limit.
    """
    total = jnp.ones(())
    for multiplier, of_cost in of_costs:
        advantage = advantage - multiplier * of_cost
        total = total + multiplier
    return advantage / total


def charge(limit: CostLimit, multiplier: Multiplier, cost: Float[Array, "..."]) -> Float[Array, "..."]:
    """Return what a step is charged for its cost: the cost itself, or with a tail its excess over the threshold.

    The mean of (cost - threshold)+ / (1 - tail) over episodes, plus the threshold, is the conditional value at risk
    (Rockafellar and Uryasev 2000, eq. 4 and theorem 1). Times `CostLimit.worth`.
    """
    if limit.tail:
        cost = jnp.maximum(cost - multiplier.threshold, 0.0) / (1.0 - limit.tail)
    return limit.worth * cost


def measured(
    limit: CostLimit, multiplier: Multiplier, cost: Float[Array, "..."], episodes: Float[Array, ""], axis: Axis = ()
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Return the mean cost of an episode, or with a tail its conditional value at risk; and the share beyond the tail.

    Both are 0 if no episode ended.

    Args:
        limit: the limit.
        multiplier: its multiplier, which has the threshold.
        cost: costs of the valid steps of a rollout, 0 in others.
        episodes: episodes that ended in the rollout, times the role's agents, on all shards.
        axis: of the shards.
    """
    spent = jax.lax.psum(jnp.sum(charge(limit, multiplier, cost)), axis) / limit.worth
    beyond = jax.lax.psum(jnp.sum(cost > multiplier.threshold, dtype=jnp.float32), axis)
    each, any_ended = jnp.maximum(episodes, 1.0), episodes > 0
    return jnp.where(any_ended, multiplier.threshold + spent / each, 0.0), jnp.where(any_ended, beyond / each, 0.0)


def controlled(limit: CostLimit, multiplier: Multiplier, cost: Float[Array, ""]) -> Multiplier:
    """Return the multiplier after an update in which the episodes' cost was ``cost``.

    Stooke 2020, algorithm 2, with the moving averages of OmniSafe's ``PIDLagrangian``.
    """
    relative = jnp.minimum(cost / limit.limit, MOST)
    error = relative - 1.0
    integral = jnp.maximum(multiplier.integral + limit.integral * error, 0.0)
    mean_error = SMOOTHING * multiplier.error + (1.0 - SMOOTHING) * error
    mean_cost = SMOOTHING * multiplier.cost + (1.0 - SMOOTHING) * relative
    rise = jnp.maximum(mean_cost - multiplier.earlier[0], 0.0)
    value = limit.proportional * mean_error + integral + limit.derivative * rise
    earlier = jnp.append(multiplier.earlier[1:], mean_cost)
    return Multiplier(jnp.maximum(value, 0.0), integral, mean_error, mean_cost, earlier, multiplier.threshold)


def tracked(limit: CostLimit, threshold: Float[Array, ""], beyond: Float[Array, ""]) -> Float[Array, ""]:
    """Return the next threshold of a tail: higher if more than 1 - tail of the episodes were beyond it, else lower.

    A step down the slope of the conditional value at risk, which is 1 - beyond / (1 - tail); of bounded size.
    """
    slope = jnp.clip(beyond / (1.0 - limit.tail) - 1.0, -1.0, 1.0)
    return jnp.maximum(threshold + THRESHOLD_STEP * limit.limit * slope, 0.0)


def next_multipliers(
    shard: Shard, multipliers: dict[str, Multiplier], played: Step
) -> tuple[dict[str, Multiplier], dict[str, Array]]:
    """Return the multipliers after a rollout, and numbers to log. They stay as they are if no episode ended in it."""
    found, metrics = {}, {}
    for name, (role, limit) in shard.config.limits.items():
        before, own = multipliers[name], shard.columns[role].own
        every = part_of(played.outcome.costs[role][limit.cost], own)
        valid = played.valid[:, own]
        cost = jnp.where(by_agent(valid, every), every, 0.0)
        ended = jax.lax.psum(jnp.sum(played.outcome.ended[:, own] & valid, dtype=jnp.float32), SHARDS)
        agents = every[0, ..., 0].size
        mean, beyond = measured(limit, before, cost, ended * agents, SHARDS)
        after = controlled(limit, before, mean)
        if limit.tail:
            after = eqx.tree_at(lambda m: m.threshold, after, tracked(limit, before.threshold, beyond))
            metrics[f"threshold/{role}/{limit.cost}"] = after.threshold
        found[name] = jax.tree.map(lambda new, old, ended=ended: jnp.where(ended > 0, new, old), after, before)
        metrics |= {f"cost/{role}/{limit.cost}": mean, f"multiplier/{role}/{limit.cost}": found[name].value}
    return found, metrics
