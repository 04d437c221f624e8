"""How many floating-point operations the networks cost, by formula: what a training can be measured against.

Only matrix products count, two operations for each weight and row; the simulation, the optimiser and whatever is done
to every number on its own come on top. What gated roles compute only to fill their room is counted, as it is computed.
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
from jaxwalk.learning.experience import gather_views
from jaxwalk.learning.fit import gated_part
from jaxwalk.rollout import draw_batch


@dataclass(frozen=True)
class Sizes:
    """What an environment brings: how many numbers the networks read and give, and for how many agents."""

    observations: Mapping[str, Mapping[str, int]]
    """Of each learning role (or the shared critic), the features of each observation set that is read."""
    actions: Mapping[str, int]
    """Of each role, numbers that its actor gives for each agent."""
    agents: Mapping[str, int]
    """Of each role."""


@dataclass(frozen=True)
class NetworkFlops:
    """Floating-point operations for each environment step [FLOP]."""

    acting: float
    """The actors in the rollout."""
    judging: float
    """The critics' values of the rollout's states, the one after the last included."""
    fits: Mapping[str, float]
    """All epochs of each network: actors by role, critics as ``NAME critic``."""

    @property
    def total(self) -> float:
        """Of everything."""
        return self.acting + self.judging + sum(self.fits.values())


def sizes_of(environment: Environment, config: TrainConfig) -> Sizes:
    """Sizes of an environment; nothing is computed."""

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
    """What is computed for each environment step, rows that have no weight in a loss included."""
    acting, judging, fits = 0.0, 0.0, {}
    for role in config.learning_roles:
        layers = _actor_layers(config, sizes, role)
        acting += acted_rows(config, sizes, role) * forward_flops(layers)
        fits[role] = passes(config, config.roles[role].epochs) * fitted_rows(config, sizes, role) * fit_flops(layers)
    for name in (SHARED,) if config.credit == "shared" else config.learning_roles:
        layers = _critic_layers(config, sizes, name)
        epochs = max(config.roles[role].epochs for role in (config.learning_roles if name == SHARED else (name,)))
        judging += judged_rows(config, sizes, name) * forward_flops(layers)
        rows = 1 if name == SHARED else fitted_rows(config, sizes, name)
        fits[f"{name} critic"] = passes(config, epochs) * rows * fit_flops(layers)
    return NetworkFlops(acting, judging, fits)


def forward_flops(layers: Sequence[int]) -> int:
    """One row through fully connected layers of these sizes, inputs first."""
    return sum(2 * a * b for a, b in pairwise(layers))


def fit_flops(layers: Sequence[int]) -> int:
    """One row forwards and backwards: each layer's outputs, weights' and inputs' gradients cost the same.

    Nobody needs the gradient of the first layer's inputs.
    """
    return 3 * forward_flops(layers) - forward_flops(layers[:2])


def passes(config: TrainConfig, epochs: int | float) -> float:
    """Passes over a rollout that so many epochs make, in whole minibatches (`jaxwalk.learning.fit.fit`)."""
    return max(round(epochs * config.minibatches), 1) / config.minibatches


def acted_rows(config: TrainConfig, sizes: Sizes, role: str) -> float:
    """Rows of a role's actor in a rollout, for each environment step, earlier versions' included.

    A gated role's are seen by one glance; if more have to decide, the further ones are not counted: see CHOSEN_PART.
    """
    return _rows(config, sizes, role, 1 - config.roles[role].fixed, CHOSEN_PART)


def fitted_rows(config: TrainConfig, sizes: Sizes, role: str) -> float:
    """Rows of a role's actor or critic in a pass over a rollout, for each environment step: those that a gated role has
    room for, filled up with rows of no weight, which cost the same: see `gated_part`.
    """
    return _rows(config, sizes, role, _own_share(config, role), gated_part(config))


def judged_rows(config: TrainConfig, sizes: Sizes, name: str) -> float:
    """Rows that a critic values, for each environment step: the rollout's and, all of them, those after the last."""
    if name == SHARED:
        return (config.steps + 1) / config.steps
    share = _own_share(config, name)
    return _rows(config, sizes, name, share, CHOSEN_PART) + share * sizes.agents[name] / config.steps


def _own_share(config: TrainConfig, role: str) -> float:
    return own_environments(config, role) / config.environments


def _rows(config: TrainConfig, sizes: Sizes, role: str, share: float, part: int) -> float:
    """For each environment step, a role's agents in that share of environments; of a gated role one in ``part``."""
    rows = round(sizes.agents[role] * config.environments * share)
    return (-(-rows // part) if config.roles[role].gated else rows) / config.environments


def _actor_layers(config: TrainConfig, sizes: Sizes, role: str) -> tuple[int, ...]:
    choice = config.roles[role]
    return sizes.observations[role][choice.observes], *choice.actor_hidden, sizes.actions[role]


def _critic_layers(config: TrainConfig, sizes: Sizes, name: str) -> tuple[int, ...]:
    if name == SHARED:
        return sizes.observations[SHARED][GLOBAL], *config.shared_critic_hidden, 1
    choice = config.roles[name]
    return sum(sizes.observations[name][x] for x in choice.critic_observes), *choice.critic_hidden, 1
