"""Methods of search: each proposes candidates, and learns from what happened to them.

A method's state is arrays by name, so that a search can be interrupted. All methods share the grid: whatever they come
across is kept there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from jaxwalk.search.cube import Candidates, ordinary, to_normal, to_uniform
from jaxwalk.search.elites import Elites

State = dict[str, np.ndarray]
"""What a method has learned."""


@dataclass(frozen=True)
class Generation:
    """One generation of a search."""

    rng: np.random.Generator
    """Where chance comes from: the same in each run of the search."""
    number: int
    """Number of the generation, from 0."""
    count: int
    """How many candidates to propose."""

    def fresh(self, points: Float[np.ndarray, "point number"]) -> Candidates:
        """Return candidates at these points with keys of their own."""
        return Candidates(points, self.number * self.count + np.arange(len(points)))


@runtime_checkable
class Method(Protocol):
    """Proposes candidates."""

    def begin(self, dimensions: int) -> State:
        """Return the state before the first generation."""
        ...

    def ask(self, state: State, elites: Elites, turn: Generation) -> Candidates:
        """Return the candidates of a generation."""
        ...

    def tell(self, state: State, candidates: Candidates, scores: Float[np.ndarray, "point"]) -> State:
        """Return the state after a generation; scores grow towards a failure, which has 0."""
        ...


class RandomSearch:
    """Draws scenarios as an evaluation does."""

    def begin(self, dimensions: int) -> State:
        """Return how many numbers a point has."""
        return {"dimensions": np.array(dimensions)}

    def ask(self, state: State, elites: Elites, turn: Generation) -> Candidates:
        """Return ordinary candidates."""
        return turn.fresh(ordinary(turn.rng, turn.count, int(state["dimensions"])))

    def tell(self, state: State, candidates: Candidates, scores: Float[np.ndarray, "point"]) -> State:
        """Learn nothing."""
        return state


class CrossEntropy(RandomSearch):
    """Shifts the normal scores of the draws towards those of the best tenth (Rubinstein, 1999).

    A tenth of the candidates stays ordinary, and each counts by the ratio of its densities, as chance draws it and as
    it was drawn. A score moves only where the best differ clearly from ordinary ones: of thousands of scores, most
    don't matter, and noise in all of them would make every candidate implausible.
    """

    elite: float = 0.1
    """Share of the best."""
    mixed: float = 0.1
    """Share of ordinary candidates."""
    clear: float = 3.0
    """A mean differs clearly if it is this many standard errors off 0."""
    pace: float = 0.7
    """How far the mean moves in a generation, of the way to that of the best."""

    def begin(self, dimensions: int) -> State:
        """Return ordinary scores: a mean of 0."""
        return {"mean": np.zeros(dimensions)}

    def ask(self, state: State, elites: Elites, turn: Generation) -> Candidates:
        """Return candidates about the mean, and some ordinary ones."""
        scores = turn.rng.standard_normal((turn.count, len(state["mean"])))
        shifted = turn.rng.random((turn.count, 1)) >= self.mixed
        return turn.fresh(to_uniform(scores + shifted * state["mean"]))

    def tell(self, state: State, candidates: Candidates, scores: Float[np.ndarray, "point"]) -> State:
        """Move the mean."""
        mean, normal = state["mean"], to_normal(candidates.points)
        log_ratio = normal @ mean - mean @ mean / 2  # of the density about the mean to the ordinary one
        weights = 1 / (self.mixed + (1 - self.mixed) * np.exp(np.clip(log_ratio, -700, 700)))
        best = np.argsort(-scores, kind="stable")[: max(2, round(self.elite * len(scores)))]
        own = weights[best] / weights[best].sum()
        centre = own @ normal[best]
        error = np.sqrt((own**2).sum())
        centre = np.where(np.abs(centre) > self.clear * error, centre, 0.0)
        return {"mean": (1 - self.pace) * mean + self.pace * centre}
