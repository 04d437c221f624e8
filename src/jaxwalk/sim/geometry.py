"""Points and vectors on the ground."""

from __future__ import annotations

from jaxtyping import Array


def to_frame(x, y, cos, sin):
    """Return a vector in the axes of somebody who faces (cos, sin): ahead and to the left. Also for NumPy arrays."""
    return x * cos + y * sin, y * cos - x * sin


def rotate(cos: Array, sin: Array, cos_turn: Array, sin_turn: Array) -> tuple[Array, Array]:
    """Turn a unit vector. One Newton step keeps its length at 1; otherwise rounding would add up over an episode."""
    new_cos, new_sin = cos * cos_turn - sin * sin_turn, sin * cos_turn + cos * sin_turn
    scale = 1.5 - 0.5 * (new_cos * new_cos + new_sin * new_sin)
    return new_cos * scale, new_sin * scale
