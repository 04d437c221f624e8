"""Compute how much a pedestrian's crossings can reveal about its jaywalking tendency tau, at most.

The prior of tau is the world's: uniform in [0, 1], or a few numbers with their shares. A crossing is a jaywalk with
probability min(1, multiplier x tau) (paper, equation 1). The number of crossings is assumed to carry no information
about tau. All results are then exact: sums over the number of jaywalks, and an integral or a sum over tau.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import scipy
from jaxtyping import Float, Int

from jaxwalk.metrics.crossings import Crossings
from jaxwalk.metrics.statistics import ratio

UNIFORM: Mapping[float, float] = MappingProxyType({})
"""No values of tau with shares: it is uniform."""
NODES = 128
"""Nodes of the Gauss-Legendre quadrature, on either side of the tau from which every crossing is a jaywalk."""


@dataclass(frozen=True)
class Identifiability:
    """What can be known about tau, on average over people."""

    people: int
    crossings: float
    """Crossings seen per person, on average."""
    never: float
    """Share of people without any crossing seen."""
    deviation: float
    """Expected posterior standard deviation of tau."""
    explained: float
    """Share of tau's variance that the crossings explain: 1 - expected posterior variance / prior variance."""
    bits: float
    """Mutual information of tau and what was seen."""


def crossings_of_people(table: Crossings, *, episodes: int, people: int) -> Int[np.ndarray, "person"]:
    """Count how often each person was seen to enter a roadway; the people of one episode are next to each other.

    Crossings without a zone, where nobody has a choice, count too: they tell nothing about tau.
    """
    person = table.episode * people + table.ped
    return np.bincount(person[table.entry_seen], minlength=episodes * people)


def identifiability(
    crossings: Int[np.ndarray, "person"], multiplier: float, tendencies: Mapping[float, float] = UNIFORM
) -> Identifiability:
    """Return what can be known about people, given the number of crossings seen of each.

    Args:
        crossings: how many were seen of each person.
        multiplier: P(jaywalk | crossing) = min(1, this x tau).
        tendencies: the values of tau with their shares (`SimConfig.tendencies`); none: it is uniform in [0, 1].

    Raises:
        ValueError: there are no people, or a number of crossings or the multiplier is negative.
    """
    if len(crossings) == 0 or crossings.min() < 0 or multiplier < 0:
        raise ValueError(f"people, crossings and multiplier must be there and not negative (multiplier {multiplier})")
    numbers, people = np.unique(crossings, return_counts=True)
    share, prior = people / people.sum(), _prior(multiplier, tendencies)
    before = prior.weight @ prior.tau**2 - (prior.weight @ prior.tau) ** 2
    deviation, variance, bits = share @ np.array([_after(number, multiplier, prior) for number in numbers.tolist()])
    return Identifiability(
        people=len(crossings),
        crossings=float(crossings.mean()),
        never=float((crossings == 0).mean()),
        deviation=float(deviation),
        explained=float(1 - variance / before) if before > 0 else 0.0,
        bits=float(bits),
    )


class _Prior(NamedTuple):
    """Values of tau and their weights, which are 1 together."""

    tau: Float[np.ndarray, "node"]
    weight: Float[np.ndarray, "node"]


def _prior(multiplier: float, tendencies: Mapping[float, float]) -> _Prior:
    if tendencies:
        return _Prior(np.array(list(tendencies)), np.array(list(tendencies.values())))
    return _quadrature(min(1.0, 1 / multiplier) if multiplier else 1.0)


def _after(crossings: int, multiplier: float, prior: _Prior) -> tuple[float, float, float]:
    """Return expected posterior deviation and variance, and mutual information [bit], after a number of crossings."""
    tau, weight = prior
    jaywalks = np.arange(crossings + 1)
    chance = scipy.stats.binom.pmf(jaywalks, crossings, np.minimum(1, multiplier * tau)[:, None])
    seen = weight @ chance
    mean, square = (ratio((weight * tau**power) @ chance, seen) for power in (1, 2))
    variance = np.where(seen > 0, np.maximum(square - mean**2, 0), 0)
    information = weight @ scipy.special.rel_entr(chance, seen).sum(axis=1) / np.log(2)
    return float(seen @ np.sqrt(variance)), float(seen @ variance), float(information)


def _quadrature(certain: float) -> _Prior:
    """Return values of a uniform tau in [0, 1] and their weights; the integrand has a kink at ``certain``."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    nodes, weights = (1 + nodes) / 2, weights / 2
    above = 1 - certain
    return _Prior(
        np.concatenate([certain * nodes, certain + above * nodes]), np.concatenate([certain * weights, above * weights])
    )
