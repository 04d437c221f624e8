"""MAP-Elites: vary what a search has kept of each cell of the grid, so that neighbouring cells are reached."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.search.cube import Candidates, stepped
from jaxwalk.search.elites import Elites
from jaxwalk.search.methods import Generation, RandomSearch, State
from jaxwalk.sim.scenario import dimensions, parts
from jaxwalk.sim.world import World

USUAL_VISITS = 10
"""A cell that was reached this often is varied half as often as a new one."""


@dataclass(frozen=True, eq=False)
class Variation:
    """One way in which a child differs from its parent."""

    group: Int[np.ndarray, "number"]
    """The group of each number of a point: those of a group step together; -1 never steps."""
    shares: tuple[float, ...]
    """Share of the groups that step: one of these for each child."""
    rhos: tuple[float, ...]
    """How much of a number stays in a step (`stepped`): one of these for each child."""

    def children(self, rng: np.random.Generator, points: Float[np.ndarray, "point number"]) -> np.ndarray:
        """Return a child of each point."""
        share, rho = (rng.choice(choices, (len(points), 1)) for choices in (self.shares, self.rhos))
        steps = (rng.random(points.shape) < share)[:, self.group] & (self.group >= 0)
        return stepped(rng, points, rho, steps)


def steps_of(world: World) -> tuple[Variation, ...]:
    """Return the ways in which a scenario of this world is varied.

    A small step of all numbers is no small change: it chooses another street, other goals, other jaywalks. So each way
    leaves most choices as they are.
    """
    numbers = np.arange(dimensions(world))
    of = parts(world, numbers)
    people = np.full(len(numbers), -1)
    people[np.concatenate([of.start[None], of.goals, of.traits, of.jaywalk, of.zone, of.earlier])] = np.arange(
        world.rules.pedestrians
    )
    return (
        Variation(people, (0.5, 0.15), (0.0, 0.5, 0.9)),
        Variation(_each_alone(numbers, of.start), (1.0, 0.3), (0.0, 0.9, 0.995)),
        Variation(_each_alone(numbers, of.traits), (1.0, 0.3), (0.0, 0.5, 0.9, 0.98)),
        Variation(_each_alone(numbers, of.traits, of.zone), (1.0, 0.3), (0.9, 0.98, 0.995)),
        Variation(numbers, (0.3, 0.1), (0.0, 0.9, 0.98)),
    )


def _each_alone(numbers: Int[np.ndarray, "number"], *some: np.ndarray) -> Int[np.ndarray, "number"]:
    """Return groups in which each of some numbers steps for itself."""
    return np.where(np.isin(numbers, np.concatenate([part.ravel() for part in some])), numbers, -1)


class MapElites(RandomSearch):
    """Varies the best scenarios of each cell, rarely reached cells more often (Mouret and Clune, 2015).

    Failures are rare at first: they are reached from near misses, which have cells too. A child has its parent's key.
    """

    of_failures: float = 0.6
    """Share of the candidates that are children of failures, where there are any."""
    new: float = 0.05
    """Share of ordinary candidates; all others are children of near misses."""

    def __init__(self, steps: tuple[Variation, ...]) -> None:
        """Vary scenarios in these ways (`steps_of` returns those of a world)."""
        self.steps = steps

    def ask(self, state: State, elites: Elites, turn: Generation) -> Candidates:
        """Return children of failures and of near misses, and ordinary candidates; the first ones are all ordinary."""
        own = super().ask(state, elites, turn)
        if not len(elites.cells):
            return own
        rng, kind = turn.rng, turn.rng.random(turn.count)
        failed = elites.failed
        parents = [_some(rng, elites, which, turn.count) for which in (failed, ~failed) if which.any()]
        chosen = elites.candidates.some(np.where(kind < self.of_failures, parents[0], parents[-1]))
        way, points = rng.integers(len(self.steps), size=turn.count), chosen.points.copy()
        for number, step in enumerate(self.steps):
            points[way == number] = step.children(rng, points[way == number])
        fresh = kind >= 1 - self.new
        return Candidates(np.where(fresh[:, None], own.points, points), np.where(fresh, own.keys, chosen.keys))


def _some(
    rng: np.random.Generator, elites: Elites, which: Bool[np.ndarray, "elite"], count: int
) -> Int[np.ndarray, "chosen"]:
    """Return elites chosen at random among some: each cell the more often, the more rarely it was reached."""
    rows = np.flatnonzero(which)
    cells, place, many = np.unique(elites.cells[rows], return_inverse=True, return_counts=True)
    chances = (1 / (many * (1 + elites.visits[cells] / USUAL_VISITS)))[place]
    return rng.choice(rows, count, p=chances / chances.sum())
