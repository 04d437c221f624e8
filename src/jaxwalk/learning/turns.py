"""One learner in several environments in turns, for example on streets with few and with many people.

Update n is made in environment n modulo their number, and in each environment the episodes go on where its last turn
left them. So a training that resumes equals one that was never interrupted, and each environment is compiled once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import jax
from jaxtyping import Array, Key

from jaxwalk.interfaces import Environment, Policy, Roles
from jaxwalk.learning import mappo
from jaxwalk.learning.config import SHARED, TrainConfig
from jaxwalk.learning.critics import Critic
from jaxwalk.learning.mappo import Learner


def init_in_turns(
    environments: Sequence[Environment],
    config: TrainConfig,
    key: Key[Array, ""],
    *,
    others: Roles[Policy | None] | None = None,
) -> Learner:
    """Return an untrained learner, as `jaxwalk.learning.mappo.init` does, with the episodes of every environment.

    Environments may differ in how many agents a role has, not in the size of what networks see.
    """
    first, *rest = environments
    learner = mappo.init(first, config, key, others=others)
    parked = [
        mappo.init(environment, config, jax.random.fold_in(key, turn), others=others).stream
        for turn, environment in enumerate(rest, 1)
    ]
    return replace(learner, parked=tuple(parked))


def update_in_turns(
    environments: Sequence[Environment], config: TrainConfig, learner: Learner, number: int
) -> tuple[Learner, dict[str, Array]]:
    """Make an update in the environment whose turn it is; ``number`` is that of updates so far."""
    turn = number % len(environments)
    streams = [learner.stream, *learner.parked]
    playing = _seated(replace(learner, stream=streams[turn], parked=()), environments[turn])
    after, metrics = mappo.update(environments[turn], config, playing)
    streams[turn] = after.stream
    return replace(_seated(after, environments[0]), stream=streams[0], parked=tuple(streams[1:])), metrics


def _seated(learner: Learner, environment: Environment) -> Learner:
    """Return the learner with as many agents in its critics, and in their optimisers, as the environment has."""

    def seat(x: object) -> object:
        if isinstance(x, Critic) and x.role != SHARED:
            return replace(x, agents=environment.roles[x.role].agents)
        return x

    return jax.tree.map(seat, learner, is_leaf=lambda x: isinstance(x, Critic))
