"""Simulate how often the intervals of counts, shares and training seeds contain the truth. The command is

    python tests/reliability/coverage.py        # exits with 1 if one covers too little or too much

Events are rare, as published ones are: 1, 2, 10 or 100 are expected. Exact intervals must cover at least 95 %; the
others 93 to 97 %, or more where hardly any count is possible. A test must not reject a true hypothesis more often than
an interval may miss.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy import stats

from jaxwalk.metrics import clustered_share, crossed_mean, over_seeds, paired_difference, proportion, rate, rate_ratio
from jaxwalk.metrics.impact_tail import LEVEL, tail_mean
from jaxwalk.metrics.near_misses import THRESHOLDS, extrapolate
from jaxwalk.metrics.statistics import episode_sums, ratio

EXPECTED = (1, 2, 10, 100)
"""Expected events: of one driver, or of each training seed."""
SEEDS = (5, 10)
SPREAD = 0.3
"""Standard deviation of rates over training seeds, as a share of the mean: 0.15 points at 0.5 %, as published."""
SCENARIOS = 2000
SHARED = (0.0, 1.0)
"""Standard deviation of the scenarios' own difficulty, common to all seeds, as a share of the mean."""
NEAR_MISS = 0.25
"""Share of the scenarios with a near miss."""
EXACT, NEAR = (0.95, 1.0), (0.93, 0.97)
"""Shares of simulations in which an interval must contain the truth."""
NOISE = 3.0
"""A simulated share may be this many standard errors beyond its limits."""


@dataclass(frozen=True)
class Regime:
    """One interval, in one kind of data."""

    interval: str
    data: str
    covers: Callable[..., Any]
    """Simulates once, with a generator, and returns whether the truth was covered; or returns the probability."""
    limits: tuple[float, float]
    exact: bool = False
    """Whether ``covers`` returns a probability, and needs no generator."""


def regimes() -> Iterator[Regime]:
    """Yield everything that is simulated."""
    yield from _of_counts()
    yield from _of_clusters()
    yield from _of_seeds()
    yield from _of_near_misses()
    for expected in (10, 20, 60, 200):
        data = f"{expected} contacts of {SCENARIOS}"
        yield Regime("speed in the worst contacts", data, _worst(expected), (NEAR[0], 1.0))


def _worst(expected: float) -> Callable[[np.random.Generator], bool]:
    """Speeds of contacts are uniform; simulations with fewer than `FEW` contacts have no interval and count as held."""
    rate, slowest, fastest = expected / SCENARIOS, 1.0, 12.0
    edge = max(fastest - (fastest - slowest) * (1 - LEVEL) / rate, slowest)
    truth = (edge + fastest) / 2 * min(rate / (1 - LEVEL), 1.0)

    def covers(rng: np.random.Generator) -> bool:
        hit = rng.random(SCENARIOS) < rate
        found = tail_mean(np.where(hit, rng.uniform(slowest, fastest, SCENARIOS), 0))
        return found.low is None or found.high is None or found.low <= truth <= found.high

    return covers


def _of_counts() -> Iterator[Regime]:
    for expected in EXPECTED:
        few = EXACT if expected <= 2 else NEAR
        yield Regime(
            "share of trials", f"{expected} of {SCENARIOS}", partial(share_covers, expected, SCENARIOS), few, exact=True
        )
        yield Regime("events per km (Poisson)", f"{expected}", partial(_rate_covers, expected), EXACT, exact=True)
        if expected < 100:
            yield Regime(
                "share of collisions", f"{expected} of 67", partial(share_covers, expected, 67), few, exact=True
            )
            yield Regime(
                "ratio of two rates", f"{expected} of 67", partial(_ratio_covers, expected, 67), EXACT, exact=True
            )
        yield Regime("paired difference", f"{expected} against {expected}", _pairs(expected), (NEAR[0], 1.0))


def share_covers(expected: float, trials: int) -> float:
    """Return the probability that the interval of a share holds the truth, with this number of events expected."""
    truth, counts = expected / trials, np.arange(trials + 1)
    likely = counts[stats.binom.pmf(counts, trials, truth) > 1e-9]
    found = [proportion(int(count), trials) for count in likely]
    return _probability(likely, [(x.low, x.high) for x in found], truth, stats.binom(trials, truth))


def _rate_covers(expected: float) -> float:
    counts = np.arange(400)
    found = [rate(int(count), 20.0) for count in counts]
    return _probability(counts, [(x.low, x.high) for x in found], expected / 20, stats.poisson(expected))


def _ratio_covers(expected: float, both: int) -> float:
    """Of ``both`` collisions, ``expected`` are jaywalkers', who have a tenth of the exposure."""
    truth, counts = expected / (both - expected) * 9, np.arange(both + 1)
    found = [rate_ratio((both - int(count), int(count)), (900.0, 100.0)) for count in counts]
    ends = [(x.low, np.inf if x.high is None else x.high) for x in found]
    return _probability(counts, ends, truth, stats.binom(both, expected / both))


def _probability(counts: np.ndarray, ends: list, truth: float, law) -> float:
    """Return the probability that the interval of a count holds the truth."""
    return float(sum(law.pmf(count) for count, (low, high) in zip(counts, ends, strict=True) if low <= truth <= high))


def _pairs(expected: float) -> Callable[[np.random.Generator], bool]:
    """Two drivers with the same rate, half of whose events are in the same scenarios."""

    def covers(rng: np.random.Generator) -> bool:
        chance = expected / 2 / SCENARIOS
        common, a, b = rng.random((3, SCENARIOS)) < chance
        found = paired_difference(common | a, common | b)
        return found.low <= 0 <= found.high

    return covers


def _of_clusters() -> Iterator[Regime]:
    for expected in EXPECTED:
        limits = (NEAR[0], 1.0) if expected <= 10 else NEAR
        yield Regime("share of encounters", f"{expected} of some {SCENARIOS}", _encounters(expected), limits)
        yield Regime("share of moments at the kerb", f"{expected} of some {SCENARIOS}", _moments(expected), limits)


def _encounters(expected: float) -> Callable[[np.random.Generator], bool]:
    """Up to five encounters in each of 800 episodes, some of which are more dangerous than others."""

    def covers(rng: np.random.Generator) -> bool:
        met = rng.integers(0, 6, 800)
        danger = np.minimum(expected / SCENARIOS * rng.gamma(1, 1, 800), 1)
        return _clustered(rng.binomial(met, danger), met, expected / SCENARIOS)

    return covers


def _moments(expected: float) -> Callable[[np.random.Generator], bool]:
    """Moments come in runs of ten, of one person in one episode, that all end alike."""

    def covers(rng: np.random.Generator) -> bool:
        people = rng.integers(1, 4, 200)
        return _clustered(10 * rng.binomial(people, expected / SCENARIOS), 10 * people, expected / SCENARIOS)

    return covers


def _clustered(successes: np.ndarray, trials: np.ndarray, truth: float) -> bool:
    sums = episode_sums({"over": successes, "under": trials}, resamples=200)
    found = clustered_share(ratio(sums["over"], sums["under"]), int(trials.sum()), int((trials > 0).sum()))
    return found.low is not None and found.high is not None and found.low <= truth <= found.high


def _of_seeds() -> Iterator[Regime]:
    for seeds, expected, shared in ((s, e, x) for s in SEEDS for e in EXPECTED for x in SHARED):
        data = f"{seeds} seeds, {expected} in each" + (", scenarios differ" if shared else "")
        yield Regime("rate over training seeds", data, _seeds(seeds, expected, shared), NEAR)
        few = (NEAR[0], 1.0) if expected <= 2 else NEAR
        yield Regime("difference over training seeds", data, _differing(seeds, expected, shared), few)
        yield Regime("its test: no difference found", data, _tested(seeds, expected, shared), few)


def _events(rng: np.random.Generator, seeds: int, expected: float, difficulty: np.ndarray) -> np.ndarray:
    """Return which scenarios end in an event under each seed; the expected rate is ``expected / SCENARIOS``."""
    luck = rng.gamma(1 / SPREAD**2, SPREAD**2, (seeds, 1))
    return rng.random((seeds, SCENARIOS)) < expected / SCENARIOS * luck * difficulty


def _difficulty(rng: np.random.Generator, shared: float) -> np.ndarray:
    """Return each scenario's own factor: 1 in the mean, and at most 4, so that no probability is beyond 1."""
    return np.ones(SCENARIOS) if shared == 0 else rng.choice([0.5, 1 + 2 * shared**2], SCENARIOS, p=[0.8, 0.2])


def _seeds(seeds: int, expected: float, shared: float) -> Callable[[np.random.Generator], bool]:
    def covers(rng: np.random.Generator) -> bool:
        ends = _events(rng, seeds, expected, _difficulty(rng, shared))
        found = over_seeds(ends, np.ones(ends.shape), kind="share").mean
        return found.low <= expected / SCENARIOS <= found.high

    return covers


def _difference(rng: np.random.Generator, seeds: int, expected: float, shared: float):
    difficulty = _difficulty(rng, shared)
    a, b = (_events(rng, seeds, expected, difficulty).astype(float) for _ in range(2))
    return crossed_mean(b - a)


def _differing(seeds: int, expected: float, shared: float) -> Callable[[np.random.Generator], bool]:
    def covers(rng: np.random.Generator) -> bool:
        low, high = _difference(rng, seeds, expected, shared).ends()
        return low <= 0 <= high

    return covers


def _tested(seeds: int, expected: float, shared: float) -> Callable[[np.random.Generator], bool]:
    def covers(rng: np.random.Generator) -> bool:
        found = _difference(rng, seeds, expected, shared)
        return found.error == 0 or found.p() >= 0.05

    return covers


def _of_near_misses() -> Iterator[Regime]:
    for shape in (-0.3, 0.0, 0.2):
        for beyond in (0.002, 0.02):
            data = f"{SCENARIOS * NEAR_MISS * beyond:g} of {SCENARIOS}, shape {shape:g}"
            yield Regime("contacts extrapolated from near misses", data, _near_misses(shape, beyond), (NEAR[0], 1.0))


def _near_misses(shape: float, beyond: float) -> Callable[[np.random.Generator], bool]:
    """Excesses over the highest threshold have a Pareto tail; the share ``beyond`` of them reaches a contact."""
    threshold = max(THRESHOLDS)
    scale = threshold * (shape / (beyond**-shape - 1) if shape else -1 / math.log(beyond))

    def covers(rng: np.random.Generator) -> bool:
        excesses = stats.genpareto.rvs(shape, scale=scale, size=rng.binomial(SCENARIOS, NEAR_MISS), random_state=rng)
        gaps = np.full(SCENARIOS, np.nan)
        gaps[: len(excesses)] = np.maximum(threshold - excesses, 0)
        found = extrapolate(gaps).extrapolated
        return found.low is None or found.high is None or found.low <= NEAR_MISS * beyond <= found.high

    return covers


def measure(regime: Regime, times: int, seed: int) -> tuple[float, float]:
    """Return the share of simulations that covered the truth, and its standard error."""
    if regime.exact:
        return float(regime.covers()), 0.0
    rng = np.random.default_rng(seed)
    covered = float(np.mean([regime.covers(rng) for _ in range(times)]))
    return covered, float(np.sqrt(max(covered * (1 - covered), 1 / times) / times))


def sound(regime: Regime, covered: float, error: float) -> bool:
    """Return whether the coverage is within the limits, but for chance."""
    low, high = regime.limits
    return low - NOISE * error - 1e-9 <= covered <= high + NOISE * error


def main() -> int:
    """Print a table of all regimes."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--times", type=int, default=1000, help="simulations of each regime")
    options.add_argument("--seed", type=int, default=0)
    chosen = options.parse_args()
    wrong = 0
    print("| interval of a | events expected | covers % | must |\n| --- | --- | --- | --- |")
    for number, regime in enumerate(regimes()):
        covered, error = measure(regime, chosen.times, chosen.seed + number)
        low, high = (f"{100 * x:g}" for x in regime.limits)
        must = f"at least {low}" if regime.limits[1] == 1 else f"{low} to {high}"
        good = sound(regime, covered, error)
        wrong += not good
        print(
            f"| {regime.interval} | {regime.data} | {100 * covered:.1f} | {must}{'' if good else ': FAILS'} |",
            flush=True,
        )
    print(
        f"\n{wrong} outside their limits; {chosen.times:,} simulations of each that is not exact"
        if wrong
        else "\nall cover"
    )
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main())
