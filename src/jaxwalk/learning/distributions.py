"""The three action distributions: categorical, clipped Gaussian and squashed Gaussian.

``raw`` is the sample before clipping or squashing. Rollouts store it, and `log_prob` takes it: recovering it from a
saturated action would give infinities. Features lead, ``(feature, *agents, *batch)``; a key array ``(*batch)`` gives
each episode of the batch its own noise.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, Key


class Categorical(eqx.Module):
    """A choice among n."""

    logits: Float[Array, "n *rest"]

    def sample(self, keys: Key[Array, "*batch"]) -> Int[Array, "*rest"]:
        """Sample by the inverse of the cumulative distribution: one uniform number for each choice."""
        uniform = _noise(jax.random.uniform, keys, self.logits.shape[1:])
        bounds = jnp.cumsum(jax.nn.softmax(self.logits, axis=0), axis=0)[:-1]
        return jnp.sum(uniform >= bounds, axis=0, dtype=jnp.int32)

    def mode(self) -> Int[Array, "*rest"]:
        """Return the likeliest choice."""
        return jnp.argmax(self.logits, axis=0).astype(jnp.int32)

    def action(self, raw: Int[Array, "*rest"]) -> Int[Array, "*rest"]:
        """Return the action for the environment."""
        return raw

    def log_prob(self, raw: Int[Array, "*rest"]) -> Float[Array, "*rest"]:
        """Return the log-probability of the choice."""
        log_p = jax.nn.log_softmax(self.logits, axis=0)
        index = jnp.arange(log_p.shape[0]).reshape(-1, *(1,) * raw.ndim)
        return jnp.sum(jnp.where(index == raw, log_p, 0.0), axis=0)

    def entropy(self, raw: Int[Array, "*rest"]) -> Float[Array, "*rest"]:
        """Return the exact entropy; ``raw`` is not needed."""
        log_p = jax.nn.log_softmax(self.logits, axis=0)
        return -jnp.sum(jnp.exp(log_p) * log_p, axis=0)


class ClippedGaussian(eqx.Module):
    """Independent Gaussians; the environment gets the action clipped to [-1, 1].

    Clipping belongs to the environment: probability and entropy are those of the Gaussian itself.
    """

    mean: Float[Array, "size *rest"]
    log_std: Float[Array, " size"]

    def sample(self, keys: Key[Array, "*batch"]) -> Float[Array, "size *rest"]:
        """Sample a raw action."""
        return self.mean + jnp.exp(_as(self.log_std, self.mean)) * _noise(jax.random.normal, keys, self.mean.shape)

    def mode(self) -> Float[Array, "size *rest"]:
        """Return the likeliest raw action."""
        return self.mean

    def action(self, raw: Float[Array, "size *rest"]) -> Float[Array, "size *rest"]:
        """Return the action for the environment."""
        return jnp.clip(raw, -1.0, 1.0)

    def log_prob(self, raw: Float[Array, "size *rest"]) -> Float[Array, "*rest"]:
        """Return the log-density of the action before clipping."""
        return jnp.sum(_normal_log_prob(raw, self.mean, _as(self.log_std, self.mean)), axis=0)

    def entropy(self, raw: Float[Array, "size *rest"]) -> Float[Array, "*rest"]:
        """Return the exact entropy; ``raw`` is not needed."""
        return jnp.broadcast_to(_normal_entropy(self.log_std), self.mean.shape[1:])


class TanhGaussian(eqx.Module):
    """Independent Gaussians squashed by tanh: the density of ``tanh(raw)`` as a function of ``raw``."""

    mean: Float[Array, "size *rest"]
    log_std: Float[Array, " size"]

    def sample(self, keys: Key[Array, "*batch"]) -> Float[Array, "size *rest"]:
        """Sample a raw action."""
        return self.mean + jnp.exp(_as(self.log_std, self.mean)) * _noise(jax.random.normal, keys, self.mean.shape)

    def mode(self) -> Float[Array, "size *rest"]:
        """Return the mean of the raw action: after squashing, it is the median."""
        return self.mean

    def action(self, raw: Float[Array, "size *rest"]) -> Float[Array, "size *rest"]:
        """Return the action for the environment."""
        return jnp.tanh(raw)

    def log_prob(self, raw: Float[Array, "size *rest"]) -> Float[Array, "*rest"]:
        """Return the log-density of the squashed action: the Gaussian's, minus the log slopes of tanh."""
        log_p = _normal_log_prob(raw, self.mean, _as(self.log_std, self.mean))
        return jnp.sum(log_p - _log_tanh_slope(raw), axis=0)

    def entropy(self, raw: Float[Array, "size *rest"]) -> Float[Array, "*rest"]:
        """Estimate the entropy of the squashed action at the sample: H(Gaussian) + log |d tanh / d raw|.

        The mean of this over samples of this policy is the entropy. The sample, written as mean + std x noise with
        fixed noise, also carries the gradient: it shrinks a mean or a spread that would saturate.
        """
        std = jnp.exp(_as(self.log_std, self.mean))
        noise = jax.lax.stop_gradient((raw - self.mean) / std)
        return _normal_entropy(self.log_std) + jnp.sum(_log_tanh_slope(self.mean + std * noise), axis=0)


Distribution = Categorical | ClippedGaussian | TanhGaussian


def _noise(sampler: Callable[..., Array], keys: Key[Array, "*batch"], shape: tuple[int, ...]) -> Array:
    """Return noise of this shape; its last axes are those of ``keys``, and every key makes its own part."""
    own = shape[: len(shape) - keys.ndim]

    def make(key: Key[Array, ""]) -> Array:
        return sampler(key, own)

    for _ in range(keys.ndim):
        make = jax.vmap(make, out_axes=len(own))
    return make(keys)


def _as(log_std: Float[Array, " size"], mean: Float[Array, "size *rest"]) -> Float[Array, "size ..."]:
    return log_std.reshape(-1, *(1,) * (mean.ndim - 1))


def _normal_log_prob(x: Array, mean: Array, log_std: Array) -> Array:
    return -0.5 * ((x - mean) * jnp.exp(-log_std)) ** 2 - log_std - 0.5 * math.log(2.0 * math.pi)


def _normal_entropy(log_std: Float[Array, " size"]) -> Float[Array, ""]:
    return jnp.sum(log_std + 0.5 * math.log(2.0 * math.pi * math.e))


def _log_tanh_slope(x: Array) -> Array:
    """Return log(1 - tanh(x)^2), finite for every finite x."""
    return 2.0 * (math.log(2.0) - x - jax.nn.softplus(-2.0 * x))
