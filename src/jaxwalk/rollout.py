"""Rollouts of an environment: `advance` (act and step), its scan over time, and restarts in between.

Ended episodes restart together, every RESTART_EVERY steps, which costs far less than a possible restart at every step.
Until then they idle, marked as not ``valid``. The step after an episode's last one records its final state, so the
value of the state *before* a restart is always available for bootstrapping.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int, Key

from jaxwalk.acting import SCENARIO_KEYS, step_key
from jaxwalk.interfaces import Environment, Outcome, Roles
from jaxwalk.platforms import few_launches

RESTART_EVERY = 8
"""Steps between restarts. An ended episode idles for 1 to 8 steps, 4.5 on average."""
RESTARTS_AT_ONCE = 16
"""The environments restart in parts of this share (1 / 16): about as many as end between two restarts."""
STEPS_AT_ONCE = 2
"""Steps in a turn of the loop on a GPU: in turns of a single step XLA copies much of what a step reads and writes."""
TRAINING, EVALUATION = 0, 1
"""Key domains of a seed, so that no evaluation uses a scenario of the training."""


@runtime_checkable
class Act(Protocol):
    """Chooses all actions of a step, and may record details (log-probabilities, observations, ...)."""

    def __call__(
        self, key: Key[Array, "*batch"], scenario: Any, state: Any, memory: Any
    ) -> tuple[Roles[Array], Any, Any]:
        """Return actions, next memory and the record."""
        ...


class Stream(eqx.Module):
    """A batch of environments that play episode after episode."""

    key: Key[Array, "env"]
    """A key for each environment, made from the seed and the environment's global index."""
    episode: Int[Array, "env"]
    """Number of the current episode and of its scenario, from 0; -1 before the first one."""
    step: Int[Array, ""]
    """Number of steps so far."""
    scenario: Any
    """Current scenarios; arrays ``(..., env)``."""
    state: Any
    """Current states; arrays ``(..., env)``."""
    memory: Any
    """Memories of the policies."""
    ended: Bool[Array, "env"]
    """Whether the episode has ended: the state is final, or follows from idling after it, until the restart."""
    shown: Bool[Array, "env"]
    """Whether a step has recorded the final state, so that the next restart may replace it."""


class Step(eqx.Module):
    """The result of one `advance`; a scan stacks it along a leading time axis."""

    record: Any
    """What the policies recorded in the state before the step."""
    outcome: Outcome
    """Outcome of the step; meaningless where not ``valid``."""
    valid: Bool[Array, "env"]
    """False while an ended episode waits for its restart."""


def seed_key(seed: int, domain: int) -> Key[Array, ""]:
    """Return the key of a seed for TRAINING or EVALUATION."""
    return _seed_key(np.int64(seed).astype(np.uint32), np.uint32(domain))


@jax.jit
def _seed_key(seed: Array, domain: Array) -> Key[Array, ""]:
    """Return the key. As a program of its own: each operation by itself would be one, and every run begins here."""
    return jax.random.fold_in(jax.random.key(seed), domain)


def environment_keys(key: Key[Array, ""], first: int, count: int) -> Key[Array, "env"]:
    """Return the keys of the environments with global indices first .. first + count - 1.

    They don't depend on the total number of environments.
    """
    return jax.vmap(jax.random.fold_in, in_axes=(None, 0))(key, first + jnp.arange(count))


def draw_batch(environment: Environment, keys: Key[Array, "*batch"]) -> Any:
    """Draw scenarios for a batch of keys: arrays ``(..., *batch)``."""
    draw = environment.draw
    for _ in range(keys.ndim):
        draw = jax.vmap(draw, out_axes=-1)
    return draw(keys)


def start(environment: Environment, keys: Key[Array, "env"], memory: Any = None) -> Stream:
    """Begin the first episode in every environment."""
    scenario = draw_batch(environment, scenario_key(keys, jnp.zeros(keys.shape, jnp.int32)))
    return Stream(
        key=keys,
        episode=jnp.zeros(keys.shape, jnp.int32),
        step=jnp.zeros((), jnp.int32),
        scenario=scenario,
        state=environment.reset(scenario),
        memory=memory,
        ended=jnp.zeros(keys.shape, bool),
        shown=jnp.zeros(keys.shape, bool),
    )


def waiting(environment: Environment, keys: Key[Array, "env"], memory: Any = None) -> Stream:
    """Return environments that begin their first episode in the first `rollout`, as if an earlier one had ended.

    Until then scenario ``(..., env)`` and state ``(..., env)`` are 0. The rollout is the same as after `start`, but
    drawing scenarios is compiled only there.
    """

    def first(key: Key[Array, ""]) -> tuple[Any, Any]:
        scenario = environment.draw(key)
        return scenario, environment.reset(scenario)

    one = jax.eval_shape(first, keys[0])
    scenario, state = jax.tree.map(lambda x: jnp.zeros((*x.shape, *keys.shape), x.dtype), one)
    return Stream(
        key=keys,
        episode=jnp.full(keys.shape, -1, jnp.int32),
        step=jnp.zeros((), jnp.int32),
        scenario=scenario,
        state=state,
        memory=memory,
        ended=jnp.ones(keys.shape, bool),
        shown=jnp.ones(keys.shape, bool),
    )


def advance(environment: Environment, act: Act, stream: Stream, key: Key[Array, "env"]) -> tuple[Stream, Step]:
    """Act and step in every environment."""
    actions, memory, record = act(key, stream.scenario, stream.state, stream.memory)
    state, outcome = environment.step(stream.scenario, stream.state, actions)
    after = Stream(
        key=stream.key,
        episode=stream.episode,
        step=stream.step + 1,
        scenario=stream.scenario,
        state=state,
        memory=memory,
        ended=stream.ended | outcome.ended,
        shown=stream.ended,
    )
    return after, Step(record, outcome, ~stream.ended)


def restart(environment: Environment, stream: Stream, fresh_memory: Any = None) -> Stream:
    """Begin the next episode wherever the final state has been recorded.

    Drawing a scenario costs as much as several steps, so scenarios are drawn only where one is needed, for some of the
    environments at a time. On a GPU the launches of a draw count, not its size, and its host would have to wait for the
    answer whether another part is needed: there they are drawn for all environments at once.
    """
    if few_launches():
        return _restarted(environment, stream, fresh_memory)
    return jax.lax.while_loop(lambda s: s.shown.any(), lambda s: _some_restarted(environment, s, fresh_memory), stream)


def _restarted(environment: Environment, stream: Stream, fresh_memory: Any) -> Stream:
    """Return the environments after their restarts. Draws a scenario for each, needed or not."""
    episode = stream.episode + stream.shown
    scenario = draw_batch(environment, scenario_key(stream.key, episode))

    def put(old: Array, new: Array) -> Array:
        return jnp.where(stream.shown, new, old)

    return Stream(
        key=stream.key,
        episode=episode,
        step=stream.step,
        scenario=jax.tree.map(put, stream.scenario, scenario),
        state=jax.tree.map(put, stream.state, environment.reset(scenario)),
        memory=jax.tree.map(put, stream.memory, fresh_memory),
        ended=stream.ended & ~stream.shown,
        shown=jnp.zeros_like(stream.shown),
    )


def _some_restarted(environment: Environment, stream: Stream, fresh_memory: Any) -> Stream:
    """Return the environments after as many restarts as usually are needed."""
    count = stream.shown.size
    places = -(-count // RESTARTS_AT_ONCE)
    (chosen,) = jnp.nonzero(stream.shown, size=places, fill_value=count)  # past the end: nothing is written
    begins = jnp.zeros(count, bool).at[chosen].set(True, mode="drop")
    episode = stream.episode + begins
    some_or_last = jnp.minimum(chosen, count - 1)
    drawn = draw_batch(environment, scenario_key(stream.key[some_or_last], episode[some_or_last]))
    scenario, state = jax.lax.optimization_barrier((drawn, environment.reset(drawn)))  # once, not per environment

    def put(old: Array, new: Array) -> Array:
        return old.at[..., chosen].set(new, mode="drop", wrap_negative_indices=False)

    return Stream(
        key=stream.key,
        episode=episode,
        step=stream.step,
        scenario=jax.tree.map(put, stream.scenario, scenario),
        state=jax.tree.map(put, stream.state, state),
        memory=jax.tree.map(lambda old, new: jnp.where(begins, new, old), stream.memory, fresh_memory),
        ended=stream.ended & ~begins,
        shown=stream.shown & ~begins,
    )


def rollout(
    environment: Environment,
    act: Act,
    stream: Stream,
    steps: int,
    *,
    fresh_memory: Any = None,
    keep: Callable[[Step], Any] = lambda step: step,
) -> tuple[Stream, Any]:
    """Play ``steps`` steps in every environment. Return the stream and what ``keep`` returns of each `Step`.

    Kept arrays are ``(time, ...)``. Rollouts of other lengths give the same episodes, if all are multiples of
    RESTART_EVERY.
    """
    block = math.gcd(steps, RESTART_EVERY)

    def play_block(stream: Stream, _: None) -> tuple[Stream, Any]:
        stream = restart(environment, stream, fresh_memory)
        keys = jax.vmap(step_key, (None, 0))(stream.key, stream.step + jnp.arange(block))
        return jax.lax.scan(play_step, stream, keys, unroll=math.gcd(block, STEPS_AT_ONCE) if few_launches() else 1)

    def play_step(stream: Stream, key: Key[Array, "env"]) -> tuple[Stream, Any]:
        stream, step = advance(environment, act, stream, key)
        return stream, keep(step)

    stream, kept = jax.lax.scan(play_block, stream, None, length=steps // block)
    return stream, jax.tree.map(lambda x: x.reshape(steps, *x.shape[2:]), kept)


def scenario_key(keys: Key[Array, "env"], episode: Int[Array, "env"]) -> Key[Array, "env"]:
    """Return the key from which each environment's episode of that number is drawn."""
    return jax.vmap(lambda key, n: jax.random.fold_in(jax.random.fold_in(key, SCENARIO_KEYS), n))(keys, episode)
