"""Points of the unit cube of all draws, and the same as independent normal scores, which searches step through."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import scipy
from jaxtyping import Bool, Float, Int

EDGE = 2.0**-24
"""Numbers closer to 0 or 1 than this count as if they were this far away: 1 - EDGE is the largest float below 1."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Scenarios to play: points of the cube, and the numbers of the keys of the policies that play them."""

    points: Float[np.ndarray, "point number"]
    """Single precision, in (0, 1)."""
    keys: Int[np.ndarray, "point"]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.keys)

    def some(self, rows: slice | np.ndarray) -> Candidates:
        """Return those of a slice, indices or a mask."""
        return Candidates(self.points[rows], self.keys[rows])

    @staticmethod
    def joined(parts: list[Candidates]) -> Candidates:
        """Return all candidates of several parts."""
        points = np.concatenate([part.points for part in parts])
        return Candidates(points, np.concatenate([part.keys for part in parts]))


@runtime_checkable
class Scored(Protocol):
    """What can be searched: it says of each point how close it comes to a failure."""

    @property
    def dimensions(self) -> int:
        """Return how many numbers a point has."""
        ...

    def score(self, candidates: Candidates) -> Float[np.ndarray, "point"]:
        """Return a number for each candidate that grows towards a failure; 0 or more is one."""
        ...


def to_normal(points: Float[np.ndarray, "point number"]) -> Float[np.ndarray, "point number"]:
    """Return the normal scores of points, in double precision."""
    return scipy.special.ndtri(np.clip(points.astype(np.float64), EDGE, 1 - EDGE))


def to_uniform(scores: Float[np.ndarray, "point number"]) -> Float[np.ndarray, "point number"]:
    """Return the points of normal scores, in single precision; the inverse of `to_normal`, to the last bit."""
    return np.clip(scipy.special.ndtr(scores), EDGE, 1 - EDGE).astype(np.float32)


def ordinary(rng: np.random.Generator, count: int, dimensions: int) -> Float[np.ndarray, "point number"]:
    """Return points as chance draws them."""
    return to_uniform(rng.standard_normal((count, dimensions)))


def stepped(
    rng: np.random.Generator,
    points: Float[np.ndarray, "point number"],
    rho: float | Float[np.ndarray, "point 1"],
    which: Bool[np.ndarray, "point number"] | None = None,
) -> Float[np.ndarray, "point number"]:
    """Return points after a step that leaves ordinary points ordinary: rho z + sqrt(1 - rho^2) xi, xi normal.

    It is the preconditioned Crank-Nicolson step (Cotter et al. 2013), reversible for independent normal scores.

    Args:
        rng: where chance comes from.
        points: where they are.
        rho: 1 stays, 0 draws anew; one number, or one for each point.
        which: the numbers that step; all others stay.
    """
    fresh = rng.standard_normal(points.shape)
    share = np.asarray(rho)
    moved = to_uniform(share * to_normal(points) + np.sqrt(1 - share**2) * fresh)
    return moved if which is None else np.where(which, moved, points)


def ordinary_distance(points: Float[np.ndarray, "point number"]) -> Float[np.ndarray, "point"]:
    """Return the root mean square of each point's normal scores: about 1 for ordinary points of many numbers."""
    return np.sqrt((to_normal(points) ** 2).mean(axis=1))
