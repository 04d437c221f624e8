"""A batch of streets with some roles played by policies and the others from outside: shared by all adapters.

Randomness works as in a rollout and an evaluation: an environment's key and the number of its episode give the scenario
and, with the step, the policies' draws. So the first episode of key i of a seed's EVALUATION keys is scenario i of an
evaluation.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypedDict, Unpack

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Key

from jaxwalk.acting import Given, act, cast_of, step_key, typed
from jaxwalk.adapters.players import AdapterError, Weights, player, weights_of
from jaxwalk.interfaces import Outcome, Policy, Roles
from jaxwalk.policies import Groups
from jaxwalk.rollout import Step, Stream, advance, environment_keys, restart, seed_key, start
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import SimConfig, rules_of

SEEDS = 2**32
"""Upper limit of seeds: they lie in [0, this)."""
SCENARIOS = 2**30
"""Upper limit of scenario numbers: they lie in [0, this)."""
EVENTS = ("goal", "collision", "timeout")
"""How an episode can end: the first two terminate it for the driver, the last one truncates it."""


class WorldOptions(TypedDict, total=False):
    """Options that every adapter has for its street; they are those of `Street.create`."""

    maps: Sequence[str | Path]
    """Bundled maps or map files; a scenario draws one (default: ``paper``)."""
    jaywalk_multiplier: float
    """P(jaywalk | decision) = jaywalking tendency x this (default: that of ``config``, 0.25)."""
    config: SimConfig | None
    """The world's rules (default: those of `SimConfig`; on other maps than ``paper`` by footprint)."""


class Game(eqx.Module):
    """What stays the same: the street, and the policies of its roles."""

    street: Street
    policies: Roles[Policy | None]
    """The policy of each role; None for a role played from outside."""

    @classmethod
    def create(
        cls,
        *,
        driver: str | Path | Policy | None,
        pedestrians: str | Path | Policy | None,
        driver_reward: Weights = "fast",
        pedestrian_reward: Weights = "fast",
        driver_costs: Sequence[str] = (),
        **world: Unpack[WorldOptions],
    ) -> Game:
        """Return a game; ``driver`` and ``pedestrians`` are as for `player`, or None for a role played from outside.

        ``driver_costs``: names of costs to count (`jaxwalk.sim.cost.DRIVER_COSTS`).

        Where people walk in groups, leaders of a named population decide for their group.

        Raise AdapterError for an unknown name, and the errors of `Street.create`.
        """
        maps = world.get("maps", ("paper",))
        world["maps"] = (maps,) if isinstance(maps, str | Path) else tuple(maps)
        world["config"] = world.get("config") or rules_of(None, [str(name) for name in world["maps"]])
        street = Street.create(
            driver_weights=weights_of("driver", driver_reward),
            pedestrian_weights=weights_of("pedestrian", pedestrian_reward),
            driver_costs=driver_costs,
            **world,
        )
        chosen = {"driver": driver, "pedestrian": pedestrians}
        policies = {role: None if who is None else player(role, who, street.config) for role, who in chosen.items()}
        people = policies["pedestrian"]
        if people is not None and isinstance(pedestrians, str | Path) and street.world.rules.grouped:
            policies["pedestrian"] = Groups(people)
        return cls(street, policies)

    def memory(self, count: int) -> Roles[tuple[Any, ...]]:
        """Return the policies' memories at the start of ``count`` episodes."""
        roles = self.street.roles
        return typed(
            {
                role: (None if policy is None else policy.init(roles[role].agents, (count,)),)
                for role, policy in self.policies.items()
            }
        )


def keys_of(seed: int, domain: int, *, first: int = 0, count: int = 1) -> Key[Array, "env"]:
    """Return the keys ``first`` .. ``first + count - 1`` of a seed, for TRAINING or EVALUATION."""
    if not 0 <= seed < SEEDS:
        raise AdapterError(f"seed must be 0 or more and below {SEEDS}, not {seed}")
    if not 0 <= first < SCENARIOS:
        raise AdapterError(f"scenario must be 0 or more and below {SCENARIOS}, not {first}")
    return environment_keys(seed_key(int(seed), domain), int(first), count)


def begin(game: Game, keys: Key[Array, "env"]) -> Stream:
    """Return the first episode of each key."""
    return start(game.street, keys, game.memory(keys.size))


def play(game: Game, stream: Stream, actions: Roles[Array | None]) -> tuple[Stream, Step]:
    """Make one step: roles played from outside take the given actions, the others those of their policies.

    Every episode has its own random numbers for every step, whatever happened in earlier episodes. The step's record
    says where the policies' actions are in their space, ``(env,)``.
    """

    def act_or_obey(key: Key[Array, "env"], scenario: Any, state: Any, memory: Any) -> tuple[Any, Any, Array]:
        policies = {role: Given(actions[role]) if x is None else x for role, x in game.policies.items()}
        acted = act(game.street, cast_of(policies), key, scenario, state, memory)
        sound = jnp.ones(key.shape, bool)
        for role, policy in game.policies.items():
            sound &= policy is None or game.street.roles[role].contains(acted.actions[role])
        return acted.actions, acted.memory, sound

    since = stream.episode * (game.street.world.rules.horizon + 1) + stream.state.step
    return advance(game.street, act_or_obey, stream, step_key(stream.key, since))


def renew(game: Game, stream: Stream, which: Bool[Array, "env"]) -> Stream:
    """Begin the next episode wherever ``which`` is true."""
    stream = eqx.tree_at(lambda s: s.shown, stream, which)
    return restart(game.street, stream, game.memory(which.size))


def rewards_of(outcome: Outcome) -> Roles[Array]:
    """Return each agent's reward, ``(*agents, *batch)``: the sum of its terms, or 0 without terms."""
    agents = outcome.terminated
    return {role: sum(terms.values(), jnp.zeros(agents[role].shape)) for role, terms in outcome.rewards.items()}
