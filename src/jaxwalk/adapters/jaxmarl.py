"""The street with JaxMARL's interface: functions of keys and states, for `jax.jit` and `jax.vmap`. It needs no JaxMARL.

Agents are the roles without a policy. With ``driver="route-follower"``: the twelve pedestrians, who are alike, as
JaxMARL's IPPO and MAPPO scripts expect; with ``pedestrians="always-go"``: only the car; else all thirteen.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Unpack

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Bool, Int

from jaxwalk.adapters.game import EVENTS, Game, WorldOptions, begin, play, renew, rewards_of
from jaxwalk.adapters.players import AdapterError, Weights
from jaxwalk.interfaces import Outcome, Policy, Roles
from jaxwalk.rollout import Stream
from jaxwalk.sim.observation import bounds

DRIVER, PEDESTRIAN = "driver", "pedestrian_"
"""The car's name, and the prefix of the pedestrians' names."""


class ChoiceSpace:
    """A choice among ``n`` actions."""

    def __init__(self, n: int) -> None:
        self.n, self.shape, self.dtype = n, (), jnp.int32

    def sample(self, key: Array) -> Int[Array, ""]:
        return jax.random.randint(key, self.shape, 0, self.n)

    def contains(self, x: Array) -> Bool[Array, ""]:
        return (x >= 0) & (x < self.n)


class BoxSpace:
    """Arrays of numbers between bounds."""

    def __init__(self, low: Any, high: Any, shape: tuple[int, ...]) -> None:
        self.low, self.high, self.shape, self.dtype = jnp.asarray(low), jnp.asarray(high), shape, jnp.float32

    def sample(self, key: Array) -> Array:
        return jax.random.uniform(key, self.shape, minval=self.low, maxval=self.high)

    def contains(self, x: Array) -> Bool[Array, ""]:
        return ((x >= self.low) & (x <= self.high)).all()


class StreetState(eqx.Module):
    """One environment; its arrays end in an axis of size 1, the simulator's batch axis."""

    stream: Stream
    """The episode in progress, and the key from which all its episodes come."""

    @property
    def step(self) -> Int[Array, ""]:
        """Steps since the episode's start."""
        return self.stream.state.step[0]

    @property
    def done(self) -> Bool[Array, ""]:
        """Whether the episode is over."""
        return self.stream.ended[0]


Brought = tuple[dict[str, Array], StreetState, dict[str, Array], dict[str, Array], dict[str, Array]]
"""The result of a step: observations, next state, rewards, dones and infos (arrays with one number per agent)."""


class StreetMARL:
    """The street with the attributes and methods of JaxMARL's ``MultiAgentEnv``.

    An episode ends for all agents at once, and JaxMARL has one way to end: ``dones`` is true for goal, collision and
    timeout alike (``infos`` says which). `vmap` over it is cheap: `_merged` makes all environments one batch.
    """

    def __init__(
        self,
        *,
        driver: str | Path | Policy | None = None,
        pedestrians: str | Path | Policy | None = None,
        driver_observation: str = "route",
        pedestrian_observation: str = "kerb",
        driver_reward: Weights = "fast",
        pedestrian_reward: Weights = "fast",
        **world: Unpack[WorldOptions],
    ) -> None:
        """Create a street; ``driver`` and ``pedestrians`` are the policies of roles that are not agents.

        Raise ValueError for an impossible option; the message names it.
        """
        if driver is not None and pedestrians is not None:
            raise AdapterError("driver and pedestrians are both played by policies: leave one of them to the agents")
        self.game = Game.create(
            driver=driver,
            pedestrians=pedestrians,
            driver_reward=driver_reward,
            pedestrian_reward=pedestrian_reward,
            **world,
        )
        people = [] if pedestrians is not None else range(self.game.street.world.rules.pedestrians)
        by_role = {"driver": [DRIVER] if driver is None else [], "pedestrian": [f"{PEDESTRIAN}{i}" for i in people]}
        self.agent_classes = {role: names for role, names in by_role.items() if names}
        self.agents = [name for names in by_role.values() for name in names]
        self.num_agents = len(self.agents)
        self.observations = {"driver": driver_observation, "pedestrian": pedestrian_observation}
        self.views = {role: self.game.street.view(role, name) for role, name in self.observations.items()}
        seen = {role: self._space(role) for role in self.agent_classes}
        done = {"driver": BoxSpace(-1.0, 1.0, (2,)), "pedestrian": ChoiceSpace(2)}
        self.observation_spaces = {name: seen[role] for role in self.agent_classes for name in by_role[role]}
        self.action_spaces = {name: done[role] for role in self.agent_classes for name in by_role[role]}

    @property
    def name(self) -> str:
        """The name of the environment."""
        return "jaxwalk_street"

    def observation_space(self, agent: str) -> BoxSpace:
        """Return the observation space of an agent."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> BoxSpace | ChoiceSpace:
        """Return the action space: acceleration and steering as shares of their limits, or wait (0) and go (1)."""
        return self.action_spaces[agent]

    def reset(self, key: Array) -> tuple[dict[str, Array], StreetState]:
        """Begin an environment's first episode. The key determines all randomness in it and in later episodes."""

        def begins(keys: Array) -> tuple[Roles[Array], StreetState]:
            began = begin(self.game, keys)
            return self._observe(began), _state(began)

        seen, began = _merged(begins)(_typed(key)[None])
        return self._by_name(seen), began

    def step(
        self, key: Array, state: StreetState, actions: dict[str, Array], reset_state: StreetState | None = None
    ) -> Brought:
        """Make a step like `step_env`; where the episode ends, return observations and state of the next one's start.

        If ``reset_state`` is given, the next episode starts from it.
        """
        seen, after, rewards, dones, infos = self._play(state, actions, renews=reset_state is None)
        if reset_state is not None:
            fresh = self.get_obs(reset_state), reset_state
            seen, after = jax.tree.map(lambda new, old: jnp.where(dones["__all__"], new, old), fresh, (seen, after))
        return seen, after, rewards, dones, infos

    def step_env(self, key: Array, state: StreetState, actions: dict[str, Array]) -> Brought:
        """Make one step. The ``key`` is not needed: an environment has its own from `reset`."""
        return self._play(state, actions, renews=False)

    def get_obs(self, state: StreetState) -> dict[str, Array]:
        """Return every agent's observation."""
        return self._by_name(_merged(lambda now: self._observe(_stream(now)))(state))

    def get_avail_actions(self, state: StreetState) -> dict[str, Bool[Array, "2"]]:
        """Return that pedestrians can always wait and go. (The driver's actions are continuous.)"""
        return {name: jnp.ones(2, bool) for name in self.agent_classes.get("pedestrian", ())}

    def _space(self, role: str) -> BoxSpace:
        street = self.game.street
        low, high = bounds(street.world, role, self.observations[role])
        return BoxSpace(low, high, low.shape)

    def _play(self, state: StreetState, actions: dict[str, Array], *, renews: bool) -> Brought:
        """Make one step, and begin the next episode if ``renews`` and the episode ended."""

        def plays(now: StreetState, given: Roles[Array | None]) -> tuple[Any, ...]:
            after, step = play(self.game, _stream(now), given)
            after = renew(self.game, after, after.ended) if renews else after
            return self._observe(after), _state(after), rewards_of(step.outcome), step.outcome

        seen, after, rewards, outcome = _merged(plays)(state, self._together(actions))
        ended: Array = outcome.ended[0]
        dones = {name: ended for name in (*self.agents, "__all__")}
        return self._by_name(seen), after, self._by_name(rewards), dones, self._infos(outcome)

    def _observe(self, now: Stream) -> Roles[Array]:
        """Return the observations of the roles that are agents."""
        return {
            role: self.game.street.observe(now.scenario, now.state, self.views[role]) for role in self.agent_classes
        }

    def _by_name(self, each: Roles[Array]) -> dict[str, Array]:
        """Return each agent's part of arrays ``(..., env)`` and ``(..., ped, env)`` of one environment."""
        parts: dict[str, Array] = {}
        if "driver" in self.agent_classes:
            parts[DRIVER] = each["driver"][..., 0]
        for i, name in enumerate(self.agent_classes.get("pedestrian", ())):
            parts[name] = each["pedestrian"][..., i, 0]
        return parts

    def _together(self, actions: dict[str, Array]) -> Roles[Array | None]:
        """Return all agents' actions as arrays of one environment; None for a role that has a policy."""
        driver, people = None, None
        if "driver" in self.agent_classes:
            driver = jnp.asarray(actions[DRIVER], jnp.float32).reshape(2, 1)
        if "pedestrian" in self.agent_classes:
            names = self.agent_classes["pedestrian"]
            people = jnp.stack([jnp.asarray(actions[name], jnp.int32).reshape(1) for name in names])
        return {"driver": driver, "pedestrian": people}

    def _infos(self, outcome: Outcome) -> dict[str, Array]:
        """Return how the episode ended, if it did, and the reward terms: arrays with one number per agent."""
        events = {name: getattr(outcome.events, name)[0] for name in EVENTS}
        infos = {name: jnp.full((self.num_agents,), happened) for name, happened in events.items()}
        others = self.num_agents - 1
        if "driver" in self.agent_classes:
            for term, paid in outcome.rewards["driver"].items():
                infos[f"driver/{term}"] = jnp.concatenate([paid, jnp.zeros(others)])
        if "pedestrian" in self.agent_classes:
            for term, paid in outcome.rewards["pedestrian"].items():
                infos[f"pedestrian/{term}"] = jnp.concatenate([jnp.zeros(self.num_agents - len(paid)), paid[:, 0]])
        return infos


def _stream(state: StreetState) -> Stream:
    """Return the stream of a batch; it has one step count, while a state has one for each environment."""
    return eqx.tree_at(lambda s: s.step, state.stream, jnp.zeros((), jnp.int32))


def _state(stream: Stream) -> StreetState:
    return StreetState(eqx.tree_at(lambda s: s.step, stream, stream.state.step))


def _typed(key: Array) -> Array:
    """Return a key of JAX's present type; JaxMARL's scripts make the older kind, two plain numbers."""
    return key if jnp.issubdtype(key.dtype, jax.dtypes.prng_key) else jax.random.wrap_key_data(key)


def _merged(function: Any) -> Any:
    """Return the function with a `vmap` that merges the new axis into the environment axis, its arrays' last one.

    Plain `vmap` would put the new axis first, where the simulator is several times slower.
    """
    merged = custom_vmap(function)

    @merged.def_vmap
    def rule(size: int, batched: Any, *arguments: Any) -> tuple[Any, Any]:
        def join(x: Array, mapped: bool) -> Array:
            x = jnp.moveaxis(x, 0, -1) if mapped else jnp.broadcast_to(x[..., None], (*x.shape, size))
            return x.reshape(*x.shape[:-2], -1)

        def part(x: Array) -> Array:
            return jnp.moveaxis(x.reshape(*x.shape[:-1], -1, size), -1, 0)

        result = _merged(function)(*jax.tree.map(join, arguments, tuple(batched)))
        return jax.tree.map(part, result), jax.tree.map(lambda x: True, result)

    return merged
