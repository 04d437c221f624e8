"""The driver's seat in a batch of streets, for a loop in Python: inputs and outputs are NumPy arrays.

A step is one call of one compiled function, and returns one packed array to the host: many small transfers would cost
more than the simulation.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.adapters.game import EVENTS, Game, begin, play, renew
from jaxwalk.adapters.players import AdapterError
from jaxwalk.evaluation.broken import ADVICE
from jaxwalk.rollout import Stream
from jaxwalk.sim.observation import bounds

NEVER, NEXT_STEP, SAME_STEP = "never", "next step", "same step"
"""When the next episode begins: on request, in place of the step after the last one, or in the last step itself."""


class Seen(NamedTuple):
    """The result of a step; arrays ``(env, ...)``."""

    observation: Float[np.ndarray, "env feature"]
    """Observation of the state after the step, or of the next episode's first state."""
    final: Float[np.ndarray, "env feature"] | None
    """Observation of the state after the step, with SAME_STEP only."""
    terms: Float[np.ndarray, "term env"]
    """Rewards of the step, in the order of `Seat.terms`."""
    costs: Float[np.ndarray, "cost env"]
    """Costs of the step, in the order of `Seat.costs`."""
    events: Bool[np.ndarray, "event env"]
    """How the episode ended, if it did, in the order of `EVENTS`."""
    valid: Bool[np.ndarray, "env"]
    """False where the step was the start of an episode: there was no action and no reward."""

    @property
    def reward(self) -> Float[np.ndarray, "env"]:
        """The sum of the terms."""
        return self.terms.sum(axis=0)

    @property
    def cost(self) -> Float[np.ndarray, "env"]:
        """The sum of the costs."""
        return self.costs.sum(axis=0)

    @property
    def terminated(self) -> Bool[np.ndarray, "env"]:
        """Whether the car arrived or collided."""
        return self.events[0] | self.events[1]

    @property
    def truncated(self) -> Bool[np.ndarray, "env"]:
        """Whether time ran out."""
        return self.events[2]

    @property
    def ended(self) -> Bool[np.ndarray, "env"]:
        """Whether the episode ended for any reason."""
        return self.terminated | self.truncated


class SeatProgram:
    """A game, and how the seat plays it. Compiled code holds all of it as constants: they cost no time at each call.

    Equal programs share the compiled code.
    """

    def __init__(self, game: Game, observation: str, autoreset: str) -> None:
        self.game, self.autoreset = game, autoreset
        self.view = game.street.view("driver", observation)
        arrays, rest = eqx.partition(game, eqx.is_array)
        leaves, structure = jax.tree.flatten(rest)
        content = tuple((x.shape, x.dtype, np.asarray(x).tobytes()) for x in jax.tree.leaves(arrays))
        self._value = (content, tuple(leaves), structure, observation, autoreset)
        self._hash = hash(self._value)

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, SeatProgram) and self._value == other._value)


class Seat:
    """Drive the cars of ``count`` streets."""

    def __init__(self, game: Game, count: int, *, observation: str, autoreset: str) -> None:
        """Raise ValueError for an unknown observation set."""
        if count < 1:
            raise AdapterError(f"the number of environments must be at least 1, not {count}")
        self.count, street = count, game.street
        self.terms, self.costs = tuple(street.weights["driver"]), street.costs
        self.low, self.high = bounds(street.world, "driver", observation)
        self.rules = SeatProgram(game, observation, autoreset)
        self.structure = jax.tree.structure(None)
        self._leaves: list[Array] = []

    @property
    def stream(self) -> Stream:
        """The streets' current state; its keys are raw."""
        return jax.tree.unflatten(self.structure, self._begun())

    def _begun(self) -> list[Array]:
        """Return the arrays of the stream: a plain list is passed much faster than a tree of objects."""
        if not self._leaves:
            raise AdapterError("nothing has begun yet: call reset first")
        return self._leaves

    def begin(self, keys: Key[Array, "env"]) -> Float[np.ndarray, "env feature"]:
        """Begin the first episode of each key."""
        stream, seen = _begin(self.rules, jax.random.key_data(keys))
        self._leaves, self.structure = jax.tree.flatten(stream)
        return np.asarray(seen).T.copy()

    def next(self, which: Bool[np.ndarray, "env"]) -> Float[np.ndarray, "env feature"]:
        """Begin the next episode wherever ``which`` is true."""
        self._leaves, seen = _next(self.rules, self.structure, self._begun(), which)
        return np.asarray(seen).T.copy()

    def step(self, action: Any) -> Seen:
        """Make one step in every street; ``action`` is (env, 2), acceleration and steering."""
        action = np.asarray(action, np.float32)
        if action.shape != (self.count, 2):
            raise AdapterError(f"an action is acceleration and steering: {(self.count, 2)} numbers, not {action.shape}")
        if not np.isfinite(action).all():
            raise AdapterError("an action has a number that is not finite; the policy may have diverged")
        self._leaves, packed = _step(self.rules, self.structure, self._begun(), action.T)
        return self._unpacked(np.asarray(packed))

    def _unpacked(self, packed: Float[np.ndarray, "row env"]) -> Seen:
        """Unpack the result of `_step`; everything is copied, since the device reuses its memory.

        Raise AdapterError if an action of the pedestrians' policy isn't in its space.
        """
        features = len(self.low)
        both = self.rules.autoreset == SAME_STEP
        sizes = [features, features * both, len(self.terms), len(self.costs), len(EVENTS)]
        observation, final, terms, costs, events, (valid, broken) = np.split(packed, np.cumsum(sizes))
        if broken.any():
            where = f"environment {broken.argmax()}"
            raise AdapterError(f"pedestrians: an action isn't in its space ({where}); {ADVICE}")
        return Seen(
            observation=observation.T.copy(),
            final=final.T.copy() if both else None,
            terms=terms.astype(np.float64),
            costs=costs.astype(np.float64),
            events=events > 0,
            valid=valid > 0,
        )


@partial(jax.jit, static_argnums=0)
def _begin(rules: SeatProgram, keys: Array) -> tuple[Stream, Array]:
    stream = begin(rules.game, jax.random.wrap_key_data(keys))
    return _raw(stream), _observe(rules, stream)


@partial(jax.jit, static_argnums=(0, 1))
def _next(rules: SeatProgram, structure: Any, leaves: list[Array], which: Array) -> tuple[list[Array], Array]:
    stream = renew(rules.game, _keyed(jax.tree.unflatten(structure, leaves)), which)
    return jax.tree.leaves(_raw(stream)), _observe(rules, stream)


@partial(jax.jit, static_argnums=(0, 1), donate_argnums=2)
def _step(
    rules: SeatProgram, structure: Any, leaves: list[Array], action: Array
) -> tuple[list[Array], Float[Array, "row env"]]:
    """Return the stream after a step, and the array that `Seat._unpacked` takes apart."""
    stream, step = play(
        rules.game, _keyed(jax.tree.unflatten(structure, leaves)), {"driver": action, "pedestrian": None}
    )
    final = [_observe(rules, stream)] if rules.autoreset == SAME_STEP else []
    if rules.autoreset != NEVER:
        stream = renew(rules.game, stream, stream.ended if final else stream.shown)
    terms, events = step.outcome.rewards["driver"], step.outcome.events
    costs = [step.outcome.costs["driver"][name] for name in rules.game.street.costs]
    ends = (getattr(events, name) for name in EVENTS)
    earned = [*terms.values(), *costs, *ends, step.valid, ~step.record]
    rows = jnp.stack([row * step.valid for row in earned]).astype(jnp.float32)
    return jax.tree.leaves(_raw(stream)), jnp.concatenate([_observe(rules, stream), *final, rows])


def _observe(rules: SeatProgram, stream: Stream) -> Float[Array, "feature env"]:
    return rules.game.street.observe(stream.scenario, stream.state, rules.view)


def _raw(stream: Stream) -> Stream:
    return eqx.tree_at(lambda s: s.key, stream, jax.random.key_data(stream.key))


def _keyed(stream: Stream) -> Stream:
    return eqx.tree_at(lambda s: s.key, stream, jax.random.wrap_key_data(stream.key))
