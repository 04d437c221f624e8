"""The driver's seat in a batch of streets, for a loop in Python: what goes in and comes out are NumPy arrays.

A step is one call of one compiled function, and one packed array is all that it hands to the host: many small transfers
would cost more than the simulation.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.adapters.game import Game, begin, play, renew, rewards_of
from jaxwalk.adapters.players import AdapterError
from jaxwalk.interfaces import ByRole
from jaxwalk.rollout import Stream
from jaxwalk.sim.bounds import bounds
from jaxwalk.sim.environment import Events

NEVER, NEXT_STEP, SAME_STEP = "never", "next step", "same step"
"""When an ended episode gives way to the next one: when asked, in place of the step after its last, at the end of that."""
EVENTS = ("goal", "collision", "timeout")
"""How an episode can end."""


class Seen(NamedTuple):
    """What a step brought; arrays ``(env, ...)``."""

    observation: Float[np.ndarray, "env feature"]
    """Of the state after the step, or of the next episode's first one."""
    final: Float[np.ndarray, "env feature"] | None
    """With SAME_STEP: of the state after the step."""
    reward: Float[np.ndarray, "env"]
    terms: dict[str, Float[np.ndarray, "env"]]
    """The terms whose sum it is."""
    events: dict[str, Bool[np.ndarray, "env"]]
    """By the names in `EVENTS`: how the episode ended, if it did."""
    valid: Bool[np.ndarray, "env"]
    """False where the step stood for the beginning of an episode: nothing was done or earned."""

    @property
    def terminated(self) -> Bool[np.ndarray, "env"]:
        """Arrived or collided."""
        return self.events["goal"] | self.events["collision"]

    @property
    def ended(self) -> Bool[np.ndarray, "env"]:
        """For whatever reason."""
        return self.terminated | self.events["timeout"]


class Rules:
    """What of a game is no array, and how it is played: hashed once, since that is done at every call."""

    def __init__(self, game: Game, observation: str, autoreset: str) -> None:
        """Equal rules share what was compiled."""
        _, self.rest = eqx.partition(game, eqx.is_array)
        self.observation, self.autoreset = observation, autoreset
        leaves, structure = jax.tree.flatten(self.rest)
        self._value = (tuple(leaves), structure, observation, autoreset)
        self._hash = hash(self._value)

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, Rules) and self._value == other._value)


class Seat:
    """Drives the cars of ``count`` streets."""

    def __init__(self, game: Game, count: int, *, observation: str, autoreset: str) -> None:
        """Raises ValueError for an unknown observation set."""
        if count < 1:
            raise AdapterError(f"the number of environments must be at least 1, not {count}")
        self.game, self.count = game, count
        street = game.street
        self.low, self.high = bounds(street.maps, street.tables, street.config, "driver", observation)
        self.rules = Rules(game, observation, autoreset)
        self.arrays = jax.device_put(eqx.filter(game, eqx.is_array))
        self._stream: Stream | None = None
        self.last_events: Events | None = None

    @property
    def stream(self) -> Stream:
        """Where the streets stand; its keys are raw, which is quicker to hand over."""
        if self._stream is None:
            raise AdapterError("nothing has begun yet: call reset first")
        return self._stream

    def begin(self, keys: Key[Array, "env"]) -> Float[np.ndarray, "env feature"]:
        """The first episode of each key."""
        self._stream, seen = _begin(self.rules, self.arrays, jax.random.key_data(keys))
        return np.asarray(seen).T.copy()

    def next(self, which: Bool[np.ndarray, "env"]) -> Float[np.ndarray, "env feature"]:
        """The next episode wherever ``which`` says."""
        self._stream, seen = _next(self.rules, self.arrays, self.stream, which)
        return np.asarray(seen).T.copy()

    def step(self, action: Any) -> Seen:
        """One step of every street; ``action`` is (env, 2), acceleration and steering."""
        action = np.asarray(action, np.float32)
        if action.shape != (self.count, 2):
            raise AdapterError(f"an action is acceleration and steering: {(self.count, 2)} numbers, not {action.shape}")
        if not np.isfinite(action).all():
            raise AdapterError("an action has a number that is not finite; the policy may have diverged")
        self._stream, self.last_events, packed = _step(self.rules, self.arrays, self.stream, action.T)
        return self._unpacked(np.asarray(packed))

    def _unpacked(self, packed: Float[np.ndarray, "row env"]) -> Seen:
        """What `_step` packed; everything is copied, so that it stays when the device's memory is used again."""
        features, names = len(self.low), list(self.game.street.weights.driver)
        both = self.rules.autoreset == SAME_STEP
        blocks = np.split(packed, np.cumsum([features, features * both, 1, len(names), len(EVENTS)]))
        observation, final, reward, terms, events, valid = blocks
        return Seen(
            observation=observation.T.copy(),
            final=final.T.copy() if both else None,
            reward=reward[0].astype(np.float64),
            terms=dict(zip(names, terms.astype(np.float64), strict=True)),
            events=dict(zip(EVENTS, events > 0, strict=True)),
            valid=valid[0] > 0,
        )


@partial(jax.jit, static_argnums=0)
def _begin(rules: Rules, arrays: Game, keys: Array) -> tuple[Stream, Array]:
    game: Game = eqx.combine(arrays, rules.rest)
    stream = begin(game, jax.random.wrap_key_data(keys))
    return _raw(stream), _look(rules, game, stream)


@partial(jax.jit, static_argnums=0)
def _next(rules: Rules, arrays: Game, stream: Stream, which: Array) -> tuple[Stream, Array]:
    game: Game = eqx.combine(arrays, rules.rest)
    stream = renew(game, _keyed(stream), which)
    return _raw(stream), _look(rules, game, stream)


@partial(jax.jit, static_argnums=0, donate_argnums=2)
def _step(rules: Rules, arrays: Game, stream: Stream, action: Array) -> tuple[Stream, Events, Array]:
    """The stream after a step, and what `Seat._unpacked` takes apart."""
    game: Game = eqx.combine(arrays, rules.rest)
    stream, step = play(game, _keyed(stream), ByRole(action, None))
    final = [_look(rules, game, stream)] if rules.autoreset == SAME_STEP else []
    if rules.autoreset != NEVER:
        stream = renew(game, stream, stream.ended if final else stream.shown)
    terms, events = step.outcome.rewards.driver, step.outcome.events
    earned = [rewards_of(terms, step.valid), *terms.values(), *(getattr(events, name) for name in EVENTS), step.valid]
    rows = jnp.stack([row * step.valid for row in earned]).astype(jnp.float32)
    return _raw(stream), events, jnp.concatenate([_look(rules, game, stream), *final, rows])


def _look(rules: Rules, game: Game, stream: Stream) -> Float[Array, "feature env"]:
    return game.street.observe(stream.scenario, stream.state, "driver", rules.observation)


def _raw(stream: Stream) -> Stream:
    return eqx.tree_at(lambda s: s.key, stream, jax.random.key_data(stream.key))


def _keyed(stream: Stream) -> Stream:
    return eqx.tree_at(lambda s: s.key, stream, jax.random.wrap_key_data(stream.key))
