"""The numbers of a configuration that a compiled update takes as arrays: another value compiles nothing anew.

Trials of a sweep, members of a population and continued trainings that differ in nothing else share one program.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float

from jaxwalk.learning.config import TrainConfig

NAMES = (
    "learning_rate", "adam_epsilon", "max_grad_norm", "discount", "gae_lambda", "clip", "value_coefficient",
    "reward_scale",
)  # fmt: skip
"""Fields of `TrainConfig` that no shape and no choice of code depends on."""
Number = float | Float[Array, ""]
"""A number, or the array that stands for it in a compiled program."""


class Hyperparameters(eqx.Module):
    """The numbers of a `TrainConfig` that can change without compiling anew. Its docstrings say what each means."""

    learning_rate: Float[Array, ""]
    adam_epsilon: Float[Array, ""]
    max_grad_norm: Float[Array, ""]
    discount: Float[Array, ""]
    gae_lambda: Float[Array, ""]
    clip: Float[Array, ""]
    value_coefficient: Float[Array, ""]
    reward_scale: Float[Array, ""]
    entropy: dict[str, Float[Array, ""]]
    """`RoleConfig.entropy` of each role."""


def hyperparameters(config: TrainConfig) -> Hyperparameters:
    """Return the numbers of a configuration as arrays."""
    numbers: dict[str, Any] = {name: np.float32(getattr(config, name)) for name in NAMES}
    numbers["entropy"] = {role: np.float32(each.entropy) for role, each in config.roles.items()}
    return Hyperparameters(**jax.device_put(numbers))


def without_hyperparameters(config: TrainConfig) -> TrainConfig:
    """Return the configuration for which a program is compiled: 1 stands in place of each number, and of ``updates``.

    The learner holds the plan (`jaxwalk.learning.mappo.Learner.planned`).
    """
    roles = {role: replace(each, entropy=1.0) for role, each in config.roles.items()}
    return replace(config, **dict.fromkeys(NAMES, 1.0), roles=roles, updates=1)
