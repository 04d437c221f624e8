"""How much of a pedestrian's jaywalking tendency tau could be known: what its crossings tell, at most.

Before, tau is uniform in [0, 1]. A crossing is a jaywalk with probability min(1, multiplier x tau) (paper, equation 1).
How often somebody crosses is taken to say nothing about tau. Then all of this is exact: sums over the number of
jaywalks and an integral over tau.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy import special, stats

from jaxwalk.metrics.crossings import Crossings
from jaxwalk.metrics.statistics import ratio

PRIOR_VARIANCE = 1 / 12
"""Of tau before anything is seen: a standard deviation of 0.289."""
NODES = 128
"""Of the Gauss-Legendre quadrature, on either side of the tau from which every crossing is a jaywalk."""


@dataclass(frozen=True)
class Identifiability:
    """What is known of tau, on average over people."""

    people: int
    crossings: float
    """Crossings seen of each, on average."""
    never: float
    """Share of people of whom none was seen."""
    deviation: float
    """Expected posterior standard deviation of tau."""
    explained: float
    """Share of tau's variance that the crossings explain: 1 - expected posterior variance / prior variance."""
    bits: float
    """Mutual information of tau and what was seen."""


def crossings_of_people(table: Crossings, *, episodes: int, people: int) -> Int[np.ndarray, "person"]:
    """How often each person of each episode was seen to enter a roadway; the people of an episode stand together."""
    person = table.episode * people + table.ped
    return np.bincount(person[table.entry_seen], minlength=episodes * people)


def identifiability(crossings: Int[np.ndarray, "person"], multiplier: float) -> Identifiability:
    """What could be known of people of whom so many crossings were seen.

    Raises:
        ValueError: there is nobody, or a negative number of crossings or multiplier.
    """
    if len(crossings) == 0 or crossings.min() < 0 or multiplier < 0:
        raise ValueError(f"people, crossings and multiplier must be there and not negative (multiplier {multiplier})")
    numbers, people = np.unique(crossings, return_counts=True)
    share = people / people.sum()
    deviation, variance, bits = share @ np.array([_after(number, multiplier) for number in numbers.tolist()])
    return Identifiability(
        people=len(crossings),
        crossings=float(crossings.mean()),
        never=float((crossings == 0).mean()),
        deviation=float(deviation),
        explained=float(1 - variance / PRIOR_VARIANCE),
        bits=float(bits),
    )


def _after(crossings: int, multiplier: float) -> tuple[float, float, float]:
    """After so many crossings: expected posterior standard deviation and variance, mutual information [bit]."""
    tau, weight = _quadrature(min(1.0, 1 / multiplier) if multiplier else 1.0)
    jaywalks = np.arange(crossings + 1)
    chance = stats.binom.pmf(jaywalks, crossings, np.minimum(1, multiplier * tau)[:, None])
    seen = weight @ chance
    mean, square = (ratio((weight * tau**power) @ chance, seen) for power in (1, 2))
    variance = np.where(seen > 0, np.maximum(square - mean**2, 0), 0)
    information = weight @ special.rel_entr(chance, seen).sum(axis=1) / np.log(2)
    return float(seen @ np.sqrt(variance)), float(seen @ variance), float(information)


def _quadrature(certain: float) -> tuple[Float[np.ndarray, "node"], Float[np.ndarray, "node"]]:
    """Values of tau in [0, 1] and their weights; the integrand has a kink at ``certain``."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    nodes, weights = (1 + nodes) / 2, weights / 2
    above = 1 - certain
    return np.concatenate([certain * nodes, certain + above * nodes]), np.concatenate(
        [certain * weights, above * weights]
    )
