"""A batch of streets in which some roles are played by policies and the others from outside: what all adapters share.

Chance is as in a rollout and an evaluation: an environment's key and the number of its episode give the scenario and,
with the step, what policies draw. So the first episode of key i of a seed's EVALUATION keys is scenario i of an
evaluation.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Key

from jaxwalk.adapters.players import AdapterError, Weights, player, weights_of
from jaxwalk.interfaces import ByRole, Outcome, Policy
from jaxwalk.rollout import FIRST_ACTION_KEY, Step, Stream, advance, environment_keys, restart, seed_key, start
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import JAYWALK_MULTIPLIER, SimConfig

SEEDS = 2**32
"""Seeds lie in [0, this)."""
SCENARIOS = 2**30
"""Numbers of scenarios lie in [0, this)."""
EVENTS = ("goal", "collision", "timeout")
"""How an episode can end: the first two terminate it for the driver, the last truncates it."""
ROLES = ("driver", "pedestrian")
"""In the order of `ByRole`."""


class Game(eqx.Module):
    """What stays the same: the street, and who plays there."""

    street: Street
    policies: ByRole[Policy | None]
    """Who plays a role; None: it is played from outside."""

    @classmethod
    def create(
        cls,
        *,
        driver: str | Path | Policy | None,
        pedestrians: str | Path | Policy | None,
        maps: Sequence[str | Path] = ("paper",),
        config: SimConfig | None = None,
        jaywalk_multiplier: float = JAYWALK_MULTIPLIER,
        driver_reward: Weights = "fast",
        pedestrian_reward: Weights = "fast",
    ) -> Game:
        """A game; ``driver`` and ``pedestrians`` as `player` takes them, or None for a role played from outside.

        Raises AdapterError for an unknown name, and what `Street.create` raises.
        """
        if isinstance(maps, str | Path):
            maps = (maps,)
        street = Street.create(
            tuple(maps), config, jaywalk_multiplier=float(jaywalk_multiplier),
            driver_weights=weights_of("driver", driver_reward),
            pedestrian_weights=weights_of("pedestrian", pedestrian_reward),
        )  # fmt: skip
        chosen = {"driver": driver, "pedestrian": pedestrians}
        policies = [None if who is None else player(role, who) for role, who in chosen.items()]
        return cls(street, ByRole(*policies))

    def memory(self, count: int) -> ByRole[Any]:
        """What policies remember at the start of so many episodes."""

        def of(role: str) -> Any:
            policy = getattr(self.policies, role)
            return None if policy is None else policy.init(getattr(self.street.roles, role).agents, (count,))

        return ByRole(*map(of, ROLES))


def keys_of(seed: int, domain: int, *, first: int = 0, count: int = 1) -> Key[Array, "env"]:
    """The keys ``first`` .. ``first + count - 1`` of a seed, TRAINING or EVALUATION."""
    if not 0 <= seed < SEEDS:
        raise AdapterError(f"seed must be 0 or more and below {SEEDS}, not {seed}")
    if not 0 <= first < SCENARIOS:
        raise AdapterError(f"scenario must be 0 or more and below {SCENARIOS}, not {first}")
    return environment_keys(seed_key(int(seed), domain), int(first), count)


def begin(game: Game, keys: Key[Array, "env"]) -> Stream:
    """The first episode of each key."""
    return start(game.street, keys, game.memory(keys.size))


def play(game: Game, stream: Stream, actions: ByRole[Array | None]) -> tuple[Stream, Step]:
    """One step: the given actions of the roles played from outside, the policies' of the others.

    Every episode has its own random numbers for every step, whatever happened in the episodes before it.
    """

    def act(key: Key[Array, "env"], scenario: Any, state: Any, memory: ByRole[Any]) -> tuple[ByRole, ByRole, None]:
        return *decide(game, key, scenario, state, memory, actions), None

    since = stream.episode * (game.street.world.rules.horizon + 1) + stream.state.step
    now = jax.vmap(jax.random.fold_in)(stream.key, FIRST_ACTION_KEY + since)
    return advance(game.street, act, stream, now)


def decide(
    game: Game, key: Key[Array, "env"], scenario: Any, state: Any, memory: ByRole[Any], actions: ByRole[Array | None]
) -> tuple[ByRole[Array], ByRole[Any]]:
    """Everybody's actions: those given, and for the other roles their policies'; also the policies' next memories."""
    chosen, remembered = [], []
    for role, own_key in zip(ROLES, jax.vmap(jax.random.split, out_axes=1)(key), strict=True):
        policy, action, after = getattr(game.policies, role), getattr(actions, role), None
        if policy is not None:
            seen = game.street.observe(scenario, state, role, policy.observes)
            action, after = policy.act(own_key, getattr(memory, role), seen)
        chosen.append(action)
        remembered.append(after)
    return ByRole(*chosen), ByRole(*remembered)


def renew(game: Game, stream: Stream, which: Bool[Array, "env"]) -> Stream:
    """The next episode wherever ``which`` says."""
    stream = eqx.tree_at(lambda s: s.shown, stream, which)
    return restart(game.street, stream, game.memory(which.size))


def rewards_of(outcome: Outcome) -> ByRole[Array]:
    """Each agent's reward, ``(*agents, *batch)``: the sum of its terms; 0 where nothing is paid."""
    terms, agents = outcome.rewards, outcome.terminated
    return ByRole(
        sum(terms.driver.values(), jnp.zeros(agents.driver.shape)),
        sum(terms.pedestrian.values(), jnp.zeros(agents.pedestrian.shape)),
    )
