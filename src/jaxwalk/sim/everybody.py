"""Loop over the people of an episode, and pack a distance and its owner into one number."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.platforms import few_launches

AT_ONCE = 24
"""Most turns that are unrolled into one kernel on a GPU: larger ones compile slowly."""


def for_everybody(people: Any, body: Callable[[Any, Any], Any], begin: Any) -> Any:
    """Call ``body(person, found)`` for one person after the other, and return the last ``found``.

    It finds neighbours and minima without an array of all pairs. Three turns at a time are unrolled, so that one pass
    over the environments does them. Between passes the compiler stores ``found``; otherwise every reader would compute
    its inputs again. On a GPU up to `AT_ONCE` turns are unrolled: 12 people are one launch then instead of eight.

    Args:
        people: a pytree with arrays ``(ped, ...)``; ``body`` gets each person's ``(1, ...)``.
        body: returns the next ``found``.
        begin: the first ``found``.
    """

    def turn(index: Array, found: Any) -> Any:
        one = partial(jax.lax.dynamic_index_in_dim, index=index, allow_negative_indices=False)
        return body(jax.tree.map(one, people), found)

    (count,) = {len(of_all) for of_all in jax.tree.leaves(people)}
    unroll = min(count, AT_ONCE) if few_launches() else 3
    return jax.lax.fori_loop(0, count, turn, begin, unroll=max(unroll, 1))


def for_nearest(
    people: Any, away: Float[Array, "ped *batch"], within: float, body: Callable[[Any, Any], Any], begin: Any
) -> Any:
    """Do the same, the nearest person of each episode first, and end when nobody within a distance is left in any.

    ``body`` must pass over who is further ``away`` than ``within`` [m], and its result must not depend on the order. A
    GPU, whose host would have to wait for the answer whether somebody is left, calls it for everybody.
    """
    if few_launches():
        return for_everybody(people, body, begin)
    order = away.argsort(axis=0)
    nearest = jax.tree.map(lambda x: jnp.take_along_axis(x, order, axis=0), people)
    return jax.lax.fori_loop(
        0,
        (away <= within).sum(axis=0).max(),
        lambda index, found: body(jax.tree.map(lambda x: x[index][None], nearest), found),
        begin,
    )


def with_index(squared: Array, index: Array, people: int) -> Array:
    """Return squared distances as integers in the same order, with an index 0 .. ``people`` in the last bits.

    So no two are equal, and the smallest one says whose it is (`index_of`). Distances that differ by less than 1 part
    in 65,000 (200 people; a million, for 12) may count as equal. They must be finite.
    """
    mask = (1 << people.bit_length()) - 1
    return (jax.lax.bitcast_convert_type(squared, jnp.int32) & ~mask) | index.astype(jnp.int32)


def index_of(key: Array, people: int) -> Array:
    """Return the index that `with_index` packed into a key."""
    return key & ((1 << people.bit_length()) - 1)
