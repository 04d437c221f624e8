"""Evolution strategies of evosax as a method of search."""

from __future__ import annotations

import importlib.util
from functools import lru_cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from jaxwalk.search.cube import Candidates, ordinary_distance, to_normal, to_uniform
from jaxwalk.search.elites import Elites
from jaxwalk.search.methods import Generation, State

ORDINARY = 2.0
"""A candidate whose normal scores are twice as far from 0 as ordinary ones counts as if it missed by this much more
[m]: without that, the strategy leaves what is plausible."""
LEAF = "strategy."
"""Arrays of the strategy's state are named so, with a number."""


class EvosaxError(ValueError):
    """evosax is missing. The message says how to install it."""


def check_evosax() -> None:
    """Raise EvosaxError if evosax is missing."""
    if importlib.util.find_spec("evosax") is None:
        raise EvosaxError('--method evolution needs evosax; install it with: pip install "jaxwalk[search]"')


class Evolution:
    """Moves a normal distribution of candidates towards failures: separable natural evolution (Wierstra et al. 2014).

    It finds one kind of failure, and refines it.
    """

    def __init__(self, count: int) -> None:
        """Propose ``count`` candidates in each generation. Raise EvosaxError if evosax is missing."""
        check_evosax()
        self.count = count

    def begin(self, dimensions: int) -> State:
        """Return the state of a strategy that begins with ordinary candidates."""
        return _arrays(_strategy(self.count, dimensions).begin)

    def ask(self, state: State, elites: Elites, turn: Generation) -> Candidates:
        """Return the strategy's candidates."""
        strategy, now = self._now(state)
        key = jax.random.key(int(turn.rng.integers(2**31)))
        scores, _ = strategy.method.ask(key, now, strategy.params)
        return turn.fresh(to_uniform(np.asarray(scores, np.float64)))

    def tell(self, state: State, candidates: Candidates, scores: Float[np.ndarray, "point"]) -> State:
        """Return the strategy's next state; its candidates are ranked by how near to a failure and how ordinary."""
        strategy, now = self._now(state)
        loss = np.minimum(-scores, 1e6) + ORDINARY * (ordinary_distance(candidates.points) - 1)
        normal = jnp.asarray(to_normal(candidates.points), jnp.float32)
        cost = jnp.asarray(loss, jnp.float32)
        after, _ = strategy.method.tell(jax.random.key(0), normal, cost, now, strategy.params)
        return _arrays(after)

    def _now(self, state: State) -> tuple[_Strategy, Any]:
        """Return the strategy, and its state as evosax has it."""
        strategy = _strategy(self.count, int(state["dimensions"]))
        leaves = [jnp.asarray(state[f"{LEAF}{number}"]) for number in range(len(jax.tree.leaves(strategy.begin)))]
        return strategy, jax.tree.unflatten(jax.tree.structure(strategy.begin), leaves)


class _Strategy(NamedTuple):
    """A strategy of evosax."""

    method: Any
    params: Any
    begin: Any
    """Its state at first."""


@lru_cache(maxsize=8)
def _strategy(count: int, dimensions: int) -> _Strategy:
    """Return the strategy, the one that was made before if it is kept: evosax compiles each one's steps anew."""
    from evosax.algorithms import SNES

    method = SNES(population_size=count, solution=jnp.zeros(dimensions))
    params = method.default_params
    return _Strategy(method, params, method.init(jax.random.key(0), jnp.zeros(dimensions), params))


def _arrays(strategy_state: Any) -> State:
    """Return a strategy's state as arrays by name."""
    leaves = {f"{LEAF}{number}": np.asarray(leaf) for number, leaf in enumerate(jax.tree.leaves(strategy_state))}
    return leaves | {"dimensions": np.array(len(strategy_state.mean))}
