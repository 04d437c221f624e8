"""Points, vectors and rectangles on the ground."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.sim.lookup import of_map


def inside(
    rectangles: Float[Array, "map rectangle 4"], map_index: Int[Array, "*batch"], x: Array, y: Array
) -> Bool[Array, "..."]:
    """Return whether points ``(*agents, *batch)`` lie in any rectangle of their map; its edge is outside."""
    boxes = of_map(rectangles, map_index)
    boxes = boxes.reshape(*boxes.shape[:2], *(1,) * (x.ndim + 2 - boxes.ndim), *boxes.shape[2:])
    x0, y0, x1, y1 = jnp.unstack(boxes, axis=1)
    return ((x > x0) & (x < x1) & (y > y0) & (y < y1)).any(axis=0)


def to_frame(x, y, cos, sin):
    """Return a vector in the axes of somebody who faces (cos, sin): ahead and to the left. Also for NumPy arrays."""
    return x * cos + y * sin, y * cos - x * sin


def rotate(cos: Array, sin: Array, cos_turn: Array, sin_turn: Array) -> tuple[Array, Array]:
    """Turn a unit vector. One Newton step keeps its length at 1; otherwise rounding would add up over an episode."""
    new_cos, new_sin = cos * cos_turn - sin * sin_turn, sin * cos_turn + cos * sin_turn
    scale = 1.5 - 0.5 * (new_cos * new_cos + new_sin * new_sin)
    return new_cos * scale, new_sin * scale
