"""Minimise a loss over a rollout: epochs of minibatches of time steps, each gradient summed over small chunks.

Whole minibatches of a large rollout do not fit into a CPU's cache. The gradient of a sum is the sum of gradients, so
chunks of about 2,048 rows give the same result faster.
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
from jaxwalk.learning.hyperparameters import Hyperparameters
from jaxwalk.learning.losses import Actions, Targets
from jaxwalk.shards import Axis

Network = TypeVar("Network")
Entries = TypeVar("Entries", bound=Actions | Targets)
GATED_PART = 16
"""Largest result of `gated_part`."""
Loss = Callable[[Any, Any], tuple[Array, dict[str, Array]]]
"""From network and chunk to the summed loss, and sums to report; ``weight`` among them is the divisor."""


def gated_part(config: TrainConfig) -> int:
    """Return n: a gated role has room for 1 / n of the rows of a rollout, and learns from no more.

    It learns from its decisions, which are far fewer, and its critic also from the rollout's first step: there is room
    for at least two steps.
    """
    return min(GATED_PART, max(config.steps // 2, 1))


class Chunks(eqx.Module):
    """How a minibatch is cut: into groups of ``steps`` time steps, or each time step into ``parts`` of its envs."""

    steps: int = eqx.field(static=True)
    parts: int = eqx.field(static=True)


def plan_chunks(*, agents: int, environments: int, steps: int, rows: int) -> Chunks:
    """Return chunks of at most ``rows`` rows if possible, and as large as divides evenly."""
    width = agents * environments
    if width <= rows:
        return Chunks(max(k for k in range(1, steps + 1) if steps % k == 0 and k * width <= rows), 1)
    fits = (p for p in range(1, environments + 1) if environments % p == 0 and width <= rows * p)
    return Chunks(1, next(fits, environments))


def take_chunk(data: Any, times: Int[Array, " k"], part: Int[Array, ""], parts: int) -> Any:
    """Take some times and one part of the envs from arrays ``(time, ..., env)``: ``(..., k, env)``."""

    def take(x: Array) -> Array:
        chosen = x.at[times].get(mode="promise_in_bounds", wrap_negative_indices=False)
        if parts > 1:
            width = x.shape[-1] // parts
            chosen = jax.lax.dynamic_slice_in_dim(chosen, part * width, width, axis=-1)
        return jnp.moveaxis(chosen, 0, -2)

    return jax.tree.map(take, data)


def map_chunks(function: Callable[[Any], Array], data: Any, *, chunks: Chunks) -> Float[Array, "time ... env"]:
    """Apply a function to data ``(time, ..., env)`` in chunks; it keeps the last two axes of its chunk."""
    length = jax.tree.leaves(data)[0].shape[0]
    groups, parts = _places(jnp.arange(length), chunks)
    out = jax.lax.map(lambda at: function(take_chunk(data, at[0], at[1], chunks.parts)), (groups, parts))
    out = out.reshape(-1, chunks.parts, *out.shape[1:])  # (group, part, ..., k, env of the part)
    out = jnp.moveaxis(jnp.moveaxis(out, -2, 1), 2, -2)  # (group, k, ..., part, env of the part)
    return out.reshape(length, *out.shape[2:-2], -1)


def take_rows(data: Any, rows: tuple[Int[Array, " row"], ...]) -> Any:
    """Take rows from arrays ``(time, feature, *agents, env)``, each given by time, agents and env: ``(feature, row)``.

    An array without the agents' axes is the same for all agents. An index beyond an axis takes its last entry.
    """

    def take(x: Array) -> Array:
        time, *agents, env = rows
        agents = agents if x.ndim == len(rows) + 1 else []
        return x.at[(time, slice(None), *agents, env)].get(mode="clip", wrap_negative_indices=False).T

    return jax.tree.map(take, data)


def pack_weighted(data: Entries, *, columns: int) -> Entries:
    """Pack the entries with weight, from data ``(time, ..., *agents, env)``, into ``(time, ..., columns)``.

    Unused room has weight 0; if there is too little room, the last entries are dropped.
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
    """Return the gradient of the loss's weighted mean over these time steps as one vector, and the reported means.

    With ``axis``, means are over the data of all shards.
    """

    def add(total: Any, where: tuple[Array, Array]) -> tuple[Any, dict[str, Array]]:
        chunk = take_chunk(data, *where, chunks.parts)
        (_, sums), gradient = jax.value_and_grad(loss, has_aux=True)(network, chunk)
        return jax.tree.map(jnp.add, total, gradient), sums

    gradient, sums = jax.lax.scan(add, jax.tree.map(jnp.zeros_like, network), _places(times, chunks))
    vector, _ = ravel_pytree(gradient)
    numbers, as_before = ravel_pytree((vector, {name: jnp.sum(each) for name, each in sums.items()}))
    vector, sums = as_before(jax.lax.psum(numbers, axis))  # one sum over all shards instead of one for each number
    weight = jnp.maximum(sums["weight"], 1e-8)
    return vector / weight, {name: total / weight for name, total in sums.items()}


def optimiser(numbers: Hyperparameters) -> optax.GradientTransformation:
    """Return Adam with gradients of bounded norm; `descend` sets the learning rate.

    ``init`` takes a network, ``update`` the gradient as one vector. The optimiser's state consists of vectors too, in
    the order of `ravel_pytree`. The numbers are the same, but a few large kernels compile faster than many small ones.
    """
    bounded = optax.clip_by_global_norm(numbers.max_grad_norm)
    return optax.flatten(optax.chain(bounded, optax.scale_by_adam(eps=numbers.adam_epsilon)))


def learning_rate(
    begin: Float[Array, ""], updates: Int[Array, ""], planned: Int[Array, ""], *, anneal: bool
) -> Float[Array, ""]:
    """Return the rate of the next update: that of the beginning, or falling linearly to 0 after ``planned`` updates."""
    return begin * jnp.clip(1.0 - updates / planned, 0.0, 1.0) if anneal else begin


def descend(
    parameters: Float[Array, " parameter"], memory: optax.OptState, gradient: Float[Array, " parameter"], *,
    rate: Array, numbers: Hyperparameters,
) -> tuple[Float[Array, " parameter"], optax.OptState]:  # fmt: skip
    """Take one gradient step; return the parameters and the optimiser's state."""
    direction, memory = optimiser(numbers).update(gradient, memory)
    return optax.tree.add_scale(parameters, -rate, direction), memory


class Fit(NamedTuple):
    """How to fit a network to a rollout."""

    config: TrainConfig
    numbers: Hyperparameters
    rate: Float[Array, ""]
    """The learning rate."""
    epochs: int | float
    """Passes over the rollout; a fractional number leaves out the last minibatches."""
    agents: int
    """Rows in the data for each step of an environment."""
    environments: int
    axis: Axis = ()
    """If given, gradients are over the data of all shards."""


def fit(
    settings: Fit, loss: Loss, network: Network, memory: optax.OptState, data: Any, key: Key[Array, ""]
) -> tuple[Network, optax.OptState, dict[str, Array]]:
    """Fit a network by epochs of minibatches to data ``(time, ..., env)``.

    Return the network, the optimiser's state, and the means of what the loss reports. Minibatches are sets of time
    steps: permuting all rows instead costs more than the update itself.
    """
    config, epochs = settings.config, settings.epochs
    steps = len(jax.tree.leaves(data)[0])
    length = steps // config.minibatches
    chunks = plan_chunks(
        agents=settings.agents, environments=settings.environments, steps=length, rows=config.chunk_rows
    )
    whole = math.ceil(epochs)
    order = jnp.argsort(jax.random.bits(key, (whole, steps)), axis=1)  # a permutation for each epoch
    batches = order.reshape(-1, length)[: max(round(epochs * config.minibatches), 1)]

    begin, shaped = ravel_pytree(network)

    def minibatch(carry: tuple[Array, optax.OptState], times: Array) -> tuple[Any, dict[str, Array]]:
        parameters, memory = carry
        gradient, report = mean_gradient(loss, shaped(parameters), data, times, chunks=chunks, axis=settings.axis)
        report["gradient_norm"] = jnp.linalg.norm(gradient)
        return descend(parameters, memory, gradient, rate=settings.rate, numbers=settings.numbers), report

    (end, memory), reports = jax.lax.scan(minibatch, (begin, memory), batches)
    return shaped(end), memory, {name: jnp.mean(x) for name, x in reports.items() if name != "weight"}
