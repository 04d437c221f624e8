"""Extrapolate the rate of contacts from near misses, and check it: by other thresholds, the fit, and observed contacts.

Songchitruksa and Tarko (2006) estimated crashes so from post-encroachment times. Here the measure of nearness is the
smallest gap between the car's footprint and a body, one per episode.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.counts import proportion, share_ends
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.metric import Metric, Recording, Rows, Sums
from jaxwalk.metrics.pareto_tail import Excesses, ParetoFit, fit
from jaxwalk.metrics.passing import PASSING
from jaxwalk.metrics.statistics import Estimate, Rate
from jaxwalk.metrics.values import Values

THRESHOLDS = (2.0, 1.5, 1.0, 0.75, 0.5)
"""Gaps below which an encounter is a near miss [m]; the first that has no problem is extrapolated."""
FEWEST = 100
"""Fewer near misses than this are not extrapolated."""
RESOLUTION = 2**-15
"""Gaps [m] are told apart by cells of this width (0.03 mm), so that a fit needs no more memory for more of them."""
UNLIKELY = 0.05
"""A fit with a smaller p-value is a poor one."""

Problem = Literal["none", "few near misses", "poor fit", "no upper bound", "unstable"]
"""Why a threshold is not extrapolated. Unstable: its interval and that of a lower threshold have nothing in common."""


@dataclass(frozen=True)
class NearestGaps:
    """One row per episode."""

    gap: Float[np.ndarray, "episode"]
    """Smallest gap of an encounter that was nearest while the car moved [m]; 0 in contact, NaN if there is none."""


@dataclass(frozen=True)
class Tail:
    """The near misses below one threshold, extrapolated."""

    threshold: float
    """[m]"""
    shape: float | None
    """Shape of the generalised Pareto distribution; with thresholds that are low enough it does not depend on them."""
    fit: float | None
    """p-value of the fit."""
    rate: Estimate
    """Episodes with a contact / episodes, extrapolated; the count is of near misses."""
    problem: Problem


@dataclass(frozen=True)
class Extrapolation:
    """Contacts of the moving car with people on a roadway: as observed, and as near misses foretell."""

    observed: Rate
    """Share of the episodes with such a contact."""
    extrapolated: Estimate
    """The same by near misses alone; None if it cannot be extrapolated."""
    threshold: float | None
    """The threshold of the near misses [m]."""
    problem: Problem
    """Why it cannot be extrapolated: the problem of the largest threshold."""
    agrees: bool | None
    """Whether both intervals have something in common: if not, don't trust what is extrapolated."""
    tails: tuple[Tail, ...]
    """By threshold."""


def nearest_gaps(recording: Recording) -> NearestGaps:
    """Return the smallest gap of each episode."""
    met, moving = recording[ENCOUNTERS], recording[PASSING].speed >= recording.config.moving_speed
    gap = np.full(len(recording.trajectory.length), np.inf, np.float32)
    np.minimum.at(gap, met.episode[moving], met.min_gap[moving])
    return NearestGaps(np.where(np.isfinite(gap), gap, np.nan))


def extrapolate(gaps: Float[np.ndarray, "episode"] | Values) -> Extrapolation:
    """Return the contact rate observed and extrapolated, from each episode's smallest gap (`NearestGaps`)."""
    gaps = Values.of(gaps)
    observed = proportion(sum(int((piece == 0).sum()) for piece in gaps), gaps.count)
    near = gaps.each(lambda piece: piece[(piece > 0) & (piece < max(THRESHOLDS))])
    middles, times = near.each(lambda piece: (np.floor(piece / RESOLUTION) + 0.5) * RESOLUTION).distinct()
    tails = _checked([_tail(middles, times, gaps.count, threshold) for threshold in THRESHOLDS])
    chosen = next((tail for tail in tails if tail.problem == "none"), None)
    if chosen is None:
        none = Estimate(None, None, None, tails[0].rate.count)
        return Extrapolation(observed, none, None, tails[0].problem, None, tails)
    agrees = _overlap(chosen.rate, observed)
    return Extrapolation(observed, chosen.rate, chosen.threshold, "none", agrees, tails)


def _tail(
    gaps: Float[np.ndarray, "different"], times: Int[np.ndarray, "different"], episodes: int, threshold: float
) -> Tail:
    """Return the near misses below a threshold, extrapolated if there are enough of them."""
    near = gaps < threshold
    excesses = Excesses(threshold - gaps[near], times[near])
    if excesses.count < FEWEST:
        return Tail(threshold, None, None, Estimate(None, None, None, excesses.count), "few near misses")
    found = fit(excesses, threshold)
    rate = _rate(excesses.count, episodes, found)
    problem = "poor fit" if found.p < UNLIKELY else "no upper bound" if found.high is None else "none"
    return Tail(threshold, found.shape, found.p, rate, problem)


def _rate(near: int, episodes: int, found: ParetoFit) -> Estimate:
    """Return contacts per episode: near misses per episode x contacts per near miss, whose intervals are combined.

    On the scale of logarithms the distances to the ends add up as squares do (Zou and Donner, 2008).
    """
    share, (least, most) = near / episodes, share_ends(near, episodes)
    value, low, high = share * found.ratio, 0.0, None
    if found.low:
        low = value * math.exp(-math.hypot(math.log(share / least), math.log(found.ratio / found.low)))
    if found.high:
        high = value * math.exp(math.hypot(math.log(most / share), math.log(found.high / found.ratio)))
    return Estimate(min(value, 1.0), low, high and min(high, 1.0), near)


def _checked(tails: list[Tail]) -> tuple[Tail, ...]:
    """Mark tails as unstable that exclude what a lower threshold, which is nearer to a contact, finds."""
    checked = []
    for number, tail in enumerate(tails):
        lower = [other for other in tails[number + 1 :] if other.rate.value is not None]
        stable = tail.problem != "none" or all(_overlap(tail.rate, other.rate) for other in lower)
        checked.append(tail if stable else replace(tail, problem="unstable"))
    return tuple(checked)


def _overlap(a: Estimate | Rate, b: Estimate | Rate) -> bool:
    """Return whether two intervals have something in common; an end that is unknown is open."""
    ends = [(0.0 if x.low is None else x.low, 1.0 if x.high is None else x.high) for x in (a, b)]
    return max(low for low, _ in ends) <= min(high for _, high in ends)


def summarise_near_misses(rows: Rows, sums: Sums) -> Extrapolation:
    """Return the contact rate observed and extrapolated."""
    return extrapolate(rows.values(lambda chunk: chunk[NEAR_MISSES].gap))


NEAR_MISSES = Metric(
    name="near_misses", measure=nearest_gaps, needs=(ENCOUNTERS, PASSING), summarise=summarise_near_misses
)
