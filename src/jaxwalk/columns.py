"""A function of some columns of arrays: what few of them need isn't computed for all."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from jaxwalk.platforms import few_launches


def apply_where(function: Callable[[Any], Any], arguments: Any, which: Bool[Array, "*rest"], part: int) -> Any:
    """Return the function's results where ``which`` says so, and 0 elsewhere. Not differentiable.

    Few columns are selected, so the function is computed only for those, one ``part``-th of all columns at a time. A
    GPU, whose host would have to wait for the answer whether there are more, computes it for all of them.

    Args:
        function: from arrays to arrays, ``(..., column)``, column by column.
        arguments: arrays ``(..., *rest)``, of any number of other axes each.
        which: the columns.
        part: how many times as many columns there are as are computed at once.
    """
    count = which.size
    places = -(-count // part)
    if few_launches():
        return jax.tree.map(lambda x: jnp.where(which, x, jnp.zeros((), x.dtype)), function(arguments))
    flat = jax.tree.map(lambda x: x.reshape(*x.shape[: x.ndim - which.ndim], count), arguments)

    def some(progress: tuple[Array, Any]) -> tuple[Array, Any]:
        waiting, found = progress
        (chosen,) = jnp.nonzero(waiting, size=places, fill_value=count)  # an index beyond the last one is nobody
        real = jnp.where(chosen < count, chosen, chosen[0])  # so that no loop of the function runs longer for nobody
        new = function(jax.tree.map(lambda x: x[..., real], flat))
        waiting = waiting.at[chosen].set(False, mode="drop")
        return waiting, jax.tree.map(lambda x, y: x.at[..., chosen].set(y, mode="drop"), found, new)

    waiting = which.reshape(-1)
    begin = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), jax.eval_shape(function, flat))
    _, found = jax.lax.while_loop(lambda progress: progress[0].any(), some, (waiting, begin))
    return jax.tree.map(lambda x: x.reshape(*x.shape[:-1], *which.shape), found)
