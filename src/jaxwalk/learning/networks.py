"""Multilayer perceptrons on arrays with features first: ``(feature, *rest) -> (out, *rest)``.

With the rows innermost, each layer is one matrix product ``W @ x`` with long contiguous rows, which a CPU runs several
times faster than rows of features.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Key


class MLP(eqx.Module):
    """Fully connected layers with ReLU between them."""

    weights: tuple[Float[Array, "_ _"], ...]
    """One matrix for each layer: ``(out, in)``."""
    biases: tuple[Float[Array, "_"], ...]
    """One vector for each layer: ``(out,)``."""

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of features, units of each hidden layer, and outputs."""
        return (self.weights[0].shape[1], *(weight.shape[0] for weight in self.weights))

    def __call__(self, x: Float[Array, "feature *rest"]) -> Float[Array, "out *rest"]:
        """Apply the network to every column: all axes after the first are kept."""
        rows = x.reshape(x.shape[0], -1)
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            rows = jax.nn.relu(weight @ rows + bias[:, None])
        rows = self.weights[-1] @ rows + self.biases[-1][:, None]
        return rows.reshape(-1, *x.shape[1:])


def make_mlp(key: Key[Array, ""], sizes: Sequence[int], *, final_scale: float) -> MLP:
    """Return a network with orthogonal weights (scale sqrt 2, the last layer ``final_scale``) and zero biases.

    This is PPO's usual initialisation: Saxe 2014 for the weights, Andrychowicz 2021 for a nearly uniform initial
    policy.
    """
    shapes = list(zip(sizes[1:], sizes[:-1], strict=True))
    scales = [math.sqrt(2.0)] * (len(shapes) - 1) + [final_scale]
    ends = list(accumulate(math.prod(shape) for shape in shapes))
    noise = jax.random.normal(key, (ends[-1],))  # one call: each separate call would take half a second to compile
    weights = tuple(
        scale * orthogonal(noise[end - math.prod(shape) : end].reshape(shape))
        for shape, scale, end in zip(shapes, scales, ends, strict=True)
    )
    return MLP(weights, tuple(jnp.zeros(shape[0]) for shape in shapes))


def orthogonal(noise: Float[Array, "out in"]) -> Float[Array, "out in"]:
    """Return a random matrix with orthonormal rows (columns, if those are fewer), from Gaussian ``noise``.

    It uses QR, and removes the signs of R's diagonal so that all such matrices are equally likely (Mezzadri 2007).
    """
    wide = noise.shape[0] < noise.shape[1]
    q, r = jnp.linalg.qr(noise.T if wide else noise)
    q = q * jnp.where(jnp.diagonal(r) < 0, -1.0, 1.0)
    return q.T if wide else q
