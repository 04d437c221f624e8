"""Compute how many floating-point operations the networks need, by formula: a reference for the speed of training.

Only matrix products count, with two operations for each weight and row; the simulation, the optimiser and elementwise
operations come on top. Padding rows of gated roles count, since they are computed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import equinox as eqx
import jax

from jaxwalk.interfaces import Discrete, Environment
from jaxwalk.learning.actor import CHOSEN_PART
from jaxwalk.learning.casting import whole
from jaxwalk.learning.config import GLOBAL, SHARED, TrainConfig, own_environments
from jaxwalk.learning.experience import critic_reads, gather_views
from jaxwalk.learning.fit import gated_part
from jaxwalk.rollout import draw_batch


@dataclass(frozen=True)
class Sizes:
    """Sizes from the environment: how many numbers the networks read and return, and for how many agents."""

    observations: Mapping[str, Mapping[str, int]]
    """Number of features in each observation set, for each learning role (or the shared critic)."""
    actions: Mapping[str, int]
    """Outputs of each role's actor per agent."""
    agents: Mapping[str, int]
    """Number of agents of each role."""


@dataclass(frozen=True)
class NetworkFlops:
    """Floating-point operations for each environment step [FLOP]."""

    acting: float
    """Forward passes of the actors in the rollout."""
    judging: float
    """Forward passes of the critics over the rollout's states, including the one after the last step."""
    fits: Mapping[str, float]
    """All epochs of each network: actors by role, critics as ``NAME critic``."""

    @property
    def total(self) -> float:
        """The sum of all parts."""
        return self.acting + self.judging + sum(self.fits.values())


def sizes_of(environment: Environment, config: TrainConfig) -> Sizes:
    """Return the sizes of an environment, without computing anything."""

    def view() -> object:
        scenario = draw_batch(environment, jax.random.split(jax.random.key(0), 1))
        return gather_views(environment, whole(config), scenario, environment.reset(scenario))

    views = eqx.filter_eval_shape(view)
    roles = {role: environment.roles[role] for role in config.learning_roles}
    return Sizes(
        observations={reader: {name: x.shape[0] for name, x in seen.items()} for reader, seen in views.items()},
        actions={r: s.action.n if isinstance(s.action, Discrete) else s.action.size for r, s in roles.items()},
        agents={role: math.prod(spec.agents) for role, spec in roles.items()},
    )


def network_flops(config: TrainConfig, sizes: Sizes) -> NetworkFlops:
    """Return the operations for each environment step; rows without weight in a loss are included."""
    acting, judging, fits = 0.0, 0.0, {}
    for role in config.learning_roles:
        layers = _actor_layers(config, sizes, role)
        acting += acted_rows(config, sizes, role) * forward_flops(layers)
        fits[role] = passes(config, config.roles[role].epochs) * fitted_rows(config, sizes, role) * fit_flops(layers)
    observers = {name: name for name in ((SHARED,) if config.credit == "shared" else config.learning_roles)}
    for name, of in (observers | {name: role for name, (role, _) in config.limits.items()}).items():
        layers = _critic_layers(config, sizes, of)
        epochs = max(config.roles[role].epochs for role in (config.learning_roles if of == SHARED else (of,)))
        judging += judged_rows(config, sizes, of) * forward_flops(layers)
        rows = 1 if of == SHARED else fitted_rows(config, sizes, of)
        fits[f"{name} critic"] = passes(config, epochs) * rows * fit_flops(layers)
    return NetworkFlops(acting, judging, fits)


def forward_flops(layers: Sequence[int]) -> int:
    """Return the operations of one row through fully connected layers of these sizes, inputs first."""
    return sum(2 * a * b for a, b in pairwise(layers))


def fit_flops(layers: Sequence[int]) -> int:
    """Return the operations of one row forwards and backwards, per layer: outputs, weight gradients, input gradients.

    All three cost the same; the gradient of the first layer's inputs is not needed.
    """
    return 3 * forward_flops(layers) - forward_flops(layers[:2])


def passes(config: TrainConfig, epochs: int | float) -> float:
    """Return the passes over a rollout that ``epochs`` make, in whole minibatches (`jaxwalk.learning.fit.fit`)."""
    return max(round(epochs * config.minibatches), 1) / config.minibatches


def acted_rows(config: TrainConfig, sizes: Sizes, role: str) -> float:
    """Return the rows of a role's actor in a rollout, for each environment step, including earlier versions.

    For a gated role this counts one run on a part of the columns; more decisions need more runs: see CHOSEN_PART.
    """
    return _rows(config, sizes, role, 1 - config.roles[role].fixed, CHOSEN_PART)


def fitted_rows(config: TrainConfig, sizes: Sizes, role: str) -> float:
    """Return the rows of a role's actor or critic in one pass over a rollout, for each environment step.

    For a gated role this is the available room: padding rows without weight cost the same (see `gated_part`).
    """
    return _rows(config, sizes, role, _own_share(config, role), gated_part(config))


def judged_rows(config: TrainConfig, sizes: Sizes, name: str) -> float:
    """Return the rows that a critic evaluates for each environment step: the rollout's, and all after the last."""
    if name == SHARED:
        return (config.steps + 1) / config.steps
    share = _own_share(config, name)
    return _rows(config, sizes, name, share, CHOSEN_PART) + share * sizes.agents[name] / config.steps


def _own_share(config: TrainConfig, role: str) -> float:
    return own_environments(config, role) / config.environments


def _rows(config: TrainConfig, sizes: Sizes, role: str, share: float, part: int) -> float:
    """Return the rows of a role's agents in this share of environments, for each step; one in ``part`` if gated."""
    rows = round(sizes.agents[role] * config.environments * share)
    return (-(-rows // part) if config.roles[role].gated else rows) / config.environments


def _actor_layers(config: TrainConfig, sizes: Sizes, role: str) -> tuple[int, ...]:
    choice = config.roles[role]
    return sizes.observations[role][choice.observes], *choice.actor_hidden, sizes.actions[role]


def _critic_layers(config: TrainConfig, sizes: Sizes, name: str) -> tuple[int, ...]:
    if name == SHARED:
        return sizes.observations[SHARED][GLOBAL], *config.shared_critic_hidden, 1
    choice = config.roles[name]
    of_role = sizes.observations[name]
    return sum(of_role[x] for x in critic_reads(choice.critic_observes, of_role)), *choice.critic_hidden, 1
