"""Playing an environment: one `advance` (act, step, reset), and the scan of it over time.

Episodes restart in the *step after* their last one: that step shows the final state (so that its value can be
bootstrapped), ignores the actions and begins the next episode. It is marked as not ``valid``.
"""

from __future__ import annotations

from typing import Any, Protocol

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int, Key

from jaxwalk.interfaces import ByRole, Environment, Outcome

SCENARIO_KEYS, ACTION_KEYS = 0, 1
"""Domains split off an environment's key, so that what happens and what is tried never share a random number."""
TRAINING, EVALUATION = 0, 1
"""Domains split off a seed, so that no evaluation meets a scenario of the training."""


class Act(Protocol):
    """Chooses all actions of a step; may return a record of how (log-probabilities, observations, ...)."""

    def __call__(self, key: Key[Array, "*batch"], scenario: Any, state: Any, memory: Any) -> tuple[ByRole, Any, Any]:
        """Return actions, next memory and the record."""
        ...


class Stream(eqx.Module):
    """A batch of environments that play episode after episode."""

    key: Key[Array, "env"]
    """One key for each environment, made from the seed and the environment's global index."""
    episode: Int[Array, "env"]
    """Episodes begun before the current one."""
    step: Int[Array, ""]
    """Steps taken so far."""
    scenario: Any
    """What is being played; arrays ``(..., env)``."""
    state: Any
    """Where it stands; arrays ``(..., env)``."""
    memory: Any
    """What the policies remember."""
    ended: Bool[Array, "env"]
    """The state is final: the next step restarts."""


class Step(eqx.Module):
    """What a scan over `advance` stacks along a leading time axis."""

    record: Any
    """What the policies recorded, seeing the state before the step."""
    outcome: Outcome
    """What the step brought; meaningless where not ``valid``."""
    valid: Bool[Array, "env"]
    """False in the step that only restarts."""


def seed_key(seed: int, domain: int) -> Key[Array, ""]:
    """The key of a seed for TRAINING or EVALUATION."""
    return jax.random.fold_in(jax.random.key(seed), domain)


def environment_keys(key: Key[Array, ""], first: int, count: int) -> Key[Array, "env"]:
    """Keys of the environments with global indices first .. first + count - 1, however many there are in all."""
    return jax.vmap(jax.random.fold_in, in_axes=(None, 0))(key, first + jnp.arange(count))


def draw_batch(environment: Environment, keys: Key[Array, "*batch"]) -> Any:
    """Scenarios for a batch of keys: arrays ``(..., *batch)``."""
    draw = environment.draw
    for _ in range(keys.ndim):
        draw = jax.vmap(draw, out_axes=-1)
    return draw(keys)


def start(environment: Environment, keys: Key[Array, "env"], memory: Any = None) -> Stream:
    """Begin the first episode in every environment."""
    scenario = draw_batch(environment, _scenario_key(keys, jnp.zeros(keys.shape, jnp.int32)))
    return Stream(
        key=keys,
        episode=jnp.zeros(keys.shape, jnp.int32),
        step=jnp.zeros((), jnp.int32),
        scenario=scenario,
        state=environment.reset(scenario),
        memory=memory,
        ended=jnp.zeros(keys.shape, bool),
    )


def advance(
    environment: Environment, act: Act, key: Key[Array, "env"], scenario: Any, following: Any, state: Any,
    memory: Any, fresh_memory: Any, ended: Bool[Array, "env"],
) -> tuple[Any, Any, Bool[Array, "env"], Step]:  # fmt: skip
    """Act and step; where the episode had ended, begin the ``following`` scenario instead.

    Returns the next state, memory and ``ended``, and what to record.
    """
    actions, acted, record = act(key, scenario, state, memory)
    after, outcome = environment.step(scenario, state, actions)
    restart = lambda new, old: jnp.where(ended, new, old)  # noqa: E731
    state = jax.tree.map(restart, environment.reset(following), after)
    memory = jax.tree.map(restart, fresh_memory, acted)
    return state, memory, outcome.ended & ~ended, Step(record, outcome, ~ended)


def rollout(environment: Environment, act: Act, stream: Stream, steps: int, fresh_memory: Any = None):
    """Play ``steps`` steps in every environment; returns the stream and `Step` with arrays ``(time, ...)``.

    The episodes to come are drawn before the scan, as many as could possibly begin in it, and looked up in it: drawing
    inside would cost every environment a draw at every step.
    """
    episodes = 1 + -(-steps // (environment.shortest_episode + 1))
    series = _upcoming(environment, stream, episodes)
    act_keys = jax.vmap(jax.random.fold_in, in_axes=(0, None))(stream.key, ACTION_KEYS)

    def body(carry, step):
        state, memory, ended, played = carry
        key = jax.vmap(jax.random.fold_in, in_axes=(0, None))(act_keys, step)
        scenario, following = _pick(series, played), _pick(series, played + 1)
        state, memory, now_ended, recorded = advance(
            environment, act, key, scenario, following, state, memory, fresh_memory, ended
        )
        return (state, memory, now_ended, played + ended), recorded

    carry = (stream.state, stream.memory, stream.ended, jnp.zeros_like(stream.episode))
    (state, memory, ended, played), recorded = jax.lax.scan(body, carry, stream.step + jnp.arange(steps))
    stream = Stream(
        key=stream.key,
        episode=stream.episode + played,
        step=stream.step + steps,
        scenario=_pick(series, played),
        state=state,
        memory=memory,
        ended=ended,
    )
    return stream, recorded


def _scenario_key(keys: Key[Array, "env"], episode: Int[Array, "env"]) -> Key[Array, "env"]:
    return jax.vmap(lambda key, n: jax.random.fold_in(jax.random.fold_in(key, SCENARIO_KEYS), n))(keys, episode)


def _upcoming(environment: Environment, stream: Stream, episodes: int) -> Any:
    """The current scenario and those after it, along a leading axis of length ``episodes`` + 1."""
    keys = jax.vmap(_scenario_key, in_axes=(None, 0))(
        stream.key, stream.episode + 1 + jnp.arange(episodes)[:, None]
    )  # (episode, env)
    drawn = jax.vmap(lambda k: draw_batch(environment, k))(keys)
    return jax.tree.map(lambda now, later: jnp.concatenate([now[None], later]), stream.scenario, drawn)


def _pick(series: Any, played: Int[Array, "env"]) -> Any:
    """Each environment's own entry along the leading axis of ``(episode, ..., env)``."""

    def pick(table: Array) -> Array:
        index = played.reshape((1,) * (table.ndim - 1) + played.shape)
        return jnp.take_along_axis(table, index, axis=0, mode="clip")[0]

    return jax.tree.map(pick, series)
