"""MAP-Elites: vary what a search has kept of each cell of the grid, so that neighbouring cells are reached."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.scenarios.archived import scenarios_at
from jaxwalk.search.cube import Candidates, stepped
from jaxwalk.search.elites import Elites
from jaxwalk.search.methods import Generation, RandomSearch, State
from jaxwalk.sim.environment import Street
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
    """Share of the groups that step: one of these for each child. At least one group steps."""
    rhos: tuple[float, ...]
    """How much of a number stays in a step (`stepped`): one of these for each child."""

    def children(self, rng: np.random.Generator, points: Float[np.ndarray, "point number"]) -> np.ndarray:
        """Return a child of each point."""
        share, rho = (rng.choice(choices, (len(points), 1)) for choices in (self.shares, self.rhos))
        chosen = rng.random(points.shape) < share
        chosen[np.arange(len(points)), rng.choice(self.group[self.group >= 0], len(points))] = True
        return stepped(rng, points, rho, chosen[:, self.group] & (self.group >= 0))


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

    Failures are rare at first: they are reached from near misses, which have cells too. A child has its parent's key,
    and is never a copy of it, which would play the same again.
    """

    of_failures: float = 0.6
    """Share of the candidates that are children of failures, where there are any."""
    new: float = 0.05
    """Share of ordinary candidates; all others are children of near misses."""

    def __init__(self, street: Street) -> None:
        """Vary scenarios of this street (`steps_of`)."""
        self.street, self.steps = street, steps_of(street.world)

    def ask(self, state: State, elites: Elites, turn: Generation) -> Candidates:
        """Return children of failures and of near misses, and ordinary candidates; the first ones are all ordinary.

        An ordinary candidate is in the place of each child that chooses the same as its parent.
        """
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
        fresh = (kind >= 1 - self.new) | _same_scenario(self.street, chosen.points, points)
        return Candidates(np.where(fresh[:, None], own.points, points), np.where(fresh, own.keys, chosen.keys))


def _same_scenario(
    street: Street, one: Float[np.ndarray, "point number"], other: Float[np.ndarray, "point number"]
) -> Bool[np.ndarray, "point"]:
    """Return which points are the same scenario as the other's: a number that moved may choose the same as before."""
    leaves = (jax.tree.leaves(scenarios_at(street, points)) for points in (one, other))
    alike = [np.asarray(mine == its).reshape(-1, len(one)).all(axis=0) for mine, its in zip(*leaves, strict=True)]
    return np.logical_and.reduce(alike)


def _some(
    rng: np.random.Generator, elites: Elites, which: Bool[np.ndarray, "elite"], count: int
) -> Int[np.ndarray, "chosen"]:
    """Return elites chosen at random among some: each cell the more often, the more rarely it was reached."""
    rows = np.flatnonzero(which)
    cells, place, many = np.unique(elites.cells[rows], return_inverse=True, return_counts=True)
    chances = (1 / (many * (1 + elites.visits[cells] / USUAL_VISITS)))[place]
    return rng.choice(rows, count, p=chances / chances.sum())
