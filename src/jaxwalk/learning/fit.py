"""Descending a loss over a rollout: epochs of minibatches of time steps, each gradient summed over small chunks.

Whole minibatches of a large rollout do not fit a processor's cache; the gradient of a sum is the sum of gradients, so
chunks of about 2,048 rows give the same result sooner.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, Int, Key

from jaxwalk.learning.config import TrainConfig
from jaxwalk.learning.losses import Actions, Targets
from jaxwalk.shards import Axis

Network = TypeVar("Network")
Entries = TypeVar("Entries", bound=Actions | Targets)
GATED_PART = 16
"""See `gated_part`."""
Loss = Callable[[Any, Any], tuple[Array, dict[str, Array]]]
"""From network and chunk to the summed loss, and sums to report: ``weight`` (what to divide by) among them."""


def gated_part(config: TrainConfig) -> int:
    """A gated role learns from at most one in so many of its rows: its decisions, which are far fewer, and for its
    critic the first ones of the rollout, for which there is room twice."""
    return min(GATED_PART, max(config.steps // 2, 1))


class Chunks(eqx.Module):
    """How a minibatch is cut: into groups of ``steps`` time steps, or each time step into ``parts`` of its envs."""

    steps: int = eqx.field(static=True)
    parts: int = eqx.field(static=True)


def plan_chunks(*, agents: int, environments: int, steps: int, rows: int) -> Chunks:
    """Chunks of at most ``rows`` rows where that is possible, and as large as divides evenly."""
    width = agents * environments
    if width <= rows:
        return Chunks(max(k for k in range(1, steps + 1) if steps % k == 0 and k * width <= rows), 1)
    fits = (p for p in range(1, environments + 1) if environments % p == 0 and width <= rows * p)
    return Chunks(1, next(fits, environments))


def take_chunk(data: Any, times: Int[Array, " k"], part: Int[Array, ""], parts: int) -> Any:
    """From arrays ``(time, ..., env)`` those times and that part of the envs: ``(..., k, env)``."""

    def take(x: Array) -> Array:
        chosen = x.at[times].get(mode="promise_in_bounds", wrap_negative_indices=False)
        if parts > 1:
            width = x.shape[-1] // parts
            chosen = jax.lax.dynamic_slice_in_dim(chosen, part * width, width, axis=-1)
        return jnp.moveaxis(chosen, 0, -2)

    return jax.tree.map(take, data)


def map_chunks(function: Callable[[Any], Array], data: Any, *, chunks: Chunks) -> Float[Array, "time ... env"]:
    """Apply to all of the data ``(time, ..., env)`` in chunks; the function keeps the last two axes of its chunk."""
    length = jax.tree.leaves(data)[0].shape[0]
    groups, parts = _places(jnp.arange(length), chunks)
    out = jax.lax.map(lambda at: function(take_chunk(data, at[0], at[1], chunks.parts)), (groups, parts))
    out = out.reshape(-1, chunks.parts, *out.shape[1:])  # (group, part, ..., k, env of the part)
    out = jnp.moveaxis(jnp.moveaxis(out, -2, 1), 2, -2)  # (group, k, ..., part, env of the part)
    return out.reshape(length, *out.shape[2:-2], -1)


def take_rows(data: Any, rows: tuple[Int[Array, " row"], ...]) -> Any:
    """From arrays ``(time, feature, *agents, env)`` those rows, each named by time, agents and env: ``(feature, row)``.

    An array without the agents' axes is the same for all of them. An index beyond an axis takes its last entry.
    """

    def take(x: Array) -> Array:
        time, *agents, env = rows
        agents = agents if x.ndim == len(rows) + 1 else []
        return x.at[(time, slice(None), *agents, env)].get(mode="clip", wrap_negative_indices=False).T

    return jax.tree.map(take, data)


def pack_weighted(data: Entries, *, columns: int) -> Entries:
    """Pack the entries that have weight, of data ``(time, ..., *agents, env)``, into ``(time, ..., columns)``.

    Room that is left has no weight; if there is too little room, the last entries are left out.
    """
    length = data.weight.shape[0]
    room = length * columns
    rows = jnp.nonzero(data.weight > 0, size=room, fill_value=0)
    held = jnp.arange(room) < jnp.sum(data.weight > 0)

    def deal(x: Array) -> Array:
        single = x.ndim == len(rows)
        flat = take_rows(x[:, None] if single else x, rows)
        dealt = jnp.moveaxis(flat.reshape(-1, columns, length), -1, 0)
        return dealt[:, 0] if single else dealt

    dealt = jax.tree.map(deal, data)
    weight = jnp.where(jnp.moveaxis(held.reshape(columns, length), -1, 0), dealt.weight, 0.0)
    return eqx.tree_at(lambda d: d.weight, dealt, weight)


def _places(times: Int[Array, " step"], chunks: Chunks) -> tuple[Int[Array, "chunk k"], Int[Array, " chunk"]]:
    """Return the times of each chunk, and the number of its part."""
    groups = jnp.repeat(times.reshape(-1, chunks.steps), chunks.parts, axis=0)
    return groups, jnp.tile(jnp.arange(chunks.parts), groups.shape[0] // chunks.parts)


def mean_gradient(
    loss: Loss, network: Any, data: Any, times: Int[Array, " step"], *, chunks: Chunks, axis: Axis = ()
) -> tuple[Float[Array, " parameter"], dict[str, Array]]:
    """Gradient of the loss's weighted mean over these time steps, as one vector, and the means of what it reports.

    With ``axis``, over the data of all shards.
    """

    def add(total: Any, where: tuple[Array, Array]) -> tuple[Any, dict[str, Array]]:
        chunk = take_chunk(data, *where, chunks.parts)
        (_, sums), gradient = jax.value_and_grad(loss, has_aux=True)(network, chunk)
        return jax.tree.map(jnp.add, total, gradient), sums

    gradient, sums = jax.lax.scan(add, jax.tree.map(jnp.zeros_like, network), _places(times, chunks))
    vector, _ = ravel_pytree(gradient)
    numbers, as_before = ravel_pytree((vector, {name: jnp.sum(each) for name, each in sums.items()}))
    vector, sums = as_before(jax.lax.psum(numbers, axis))  # one sum over all shards, not one for each number
    weight = jnp.maximum(sums["weight"], 1e-8)
    return vector / weight, {name: total / weight for name, total in sums.items()}


def optimiser(config: TrainConfig) -> optax.GradientTransformation:
    """Adam on a gradient of bounded norm; `descend` brings the learning rate.

    ``init`` takes a network, ``update`` the gradient as one vector: what is remembered are vectors too, in the order of
    `ravel_pytree`. The numbers are the same, from a few large kernels, which compile sooner than many small.
    """
    bounded = optax.clip_by_global_norm(config.max_grad_norm)
    return optax.flatten(optax.chain(bounded, optax.scale_by_adam(eps=config.adam_epsilon)))


def learning_rate(
    config: TrainConfig, updates: Int[Array, ""], planned: Int[Array, ""] | None = None
) -> Float[Array, ""]:
    """For the update that follows so many: constant, or falling linearly to 0 after the ``planned`` number.

    The number is an array, or ``config.updates``: a change of the array compiles nothing anew.
    """
    end = config.updates if planned is None else planned
    left = jnp.clip(1.0 - updates / end, 0.0, 1.0) if config.anneal else jnp.ones(())
    return config.learning_rate * left


def descend(
    parameters: Float[Array, " parameter"], memory: optax.OptState, gradient: Float[Array, " parameter"], *,
    rate: Array, config: TrainConfig,
) -> tuple[Float[Array, " parameter"], optax.OptState]:  # fmt: skip
    """One step against the gradient; returns the parameters and what the optimiser remembers."""
    direction, memory = optimiser(config).update(gradient, memory)
    return optax.tree.add_scale(parameters, -rate, direction), memory


class Fit(NamedTuple):
    """How a network is fitted to a rollout."""

    config: TrainConfig
    rate: Float[Array, ""]
    """The learning rate."""
    epochs: int | float
    """Passes over the rollout; a broken number leaves out the last minibatches."""
    agents: int
    """Rows that the data has for each step of an environment."""
    environments: int
    axis: Axis = ()
    """With it, gradients are those of all shards' data."""


def fit(
    how: Fit, loss: Loss, network: Network, memory: optax.OptState, data: Any, key: Key[Array, ""]
) -> tuple[Network, optax.OptState, dict[str, Array]]:
    """Fit a network by epochs of minibatches to data ``(time, ..., env)``.

    Returns the network, what the optimiser remembers, and the means of what is reported. Minibatches are sets of time
    steps: permuting every row instead costs more than the update itself.
    """
    config, epochs = how.config, how.epochs
    steps = len(jax.tree.leaves(data)[0])
    length = steps // config.minibatches
    chunks = plan_chunks(agents=how.agents, environments=how.environments, steps=length, rows=config.chunk_rows)
    whole = math.ceil(epochs)
    order = jnp.argsort(jax.random.bits(key, (whole, steps)), axis=1)  # a permutation for each epoch
    batches = order.reshape(-1, length)[: max(round(epochs * config.minibatches), 1)]

    begin, shaped = ravel_pytree(network)

    def minibatch(carry: tuple[Array, optax.OptState], times: Array) -> tuple[Any, dict[str, Array]]:
        parameters, memory = carry
        gradient, report = mean_gradient(loss, shaped(parameters), data, times, chunks=chunks, axis=how.axis)
        report["gradient_norm"] = jnp.linalg.norm(gradient)
        return descend(parameters, memory, gradient, rate=how.rate, config=config), report

    (end, memory), reports = jax.lax.scan(minibatch, (begin, memory), batches)
    return shaped(end), memory, {name: jnp.mean(x) for name, x in reports.items() if name != "weight"}
