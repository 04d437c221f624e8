"""Does the analysis of raters find what raters prefer? python tests/reliability/simulated_raters.py [--spread 2]

Seven drivers of strengths with a standard deviation of 2 (--spread), and 20 simulated raters of 25 pairs each, who
answer by Davidson's model. It prints, with 95 % intervals over the sets of drivers, the mean of Kendall's tau between
the true order and the one that is found, and how many of the 95 % intervals over raters cover the true strengths; and
how often a driver is called safer than the next one that isn't.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import stats

sys.path.insert(0, str(Path(__file__).parents[1]))

from jaxwalk.raters.answer_words import headline
from jaxwalk.raters.answers_analysis import analyse
from raters.simulated import a_plan, files

DRIVERS, RATERS = 7, 20
LEAST_TAU, COVERED = 0.9, (0.93, 0.97)
"""What is required where the spread is 2: of the mean tau, and of the share of intervals that cover."""


@dataclass(frozen=True)
class Found:
    """What came of each set of drivers."""

    taus: list[float]
    covered: list[float]
    """The share of its intervals that cover."""
    wrong: list[bool]
    """Whether a driver is called safer than the next one and isn't."""
    agreements: list[str]

    @property
    def tau(self) -> float:
        return float(np.mean(self.taus))

    @property
    def coverage(self) -> float:
        return float(np.mean(self.covered))


def simulate(simulations: int, *, spread: float = 2.0, seed: int = 0, resamples: int = 500) -> Found:
    """Rate so many sets of drivers, each with other strengths and other raters."""
    rng = np.random.default_rng(seed)
    plan = a_plan(DRIVERS)
    found = Found([], [], [], [])
    for _ in range(simulations):
        truth = rng.normal(0, spread, DRIVERS)
        truth -= truth.mean()
        rated = analyse(plan, files(plan, truth, RATERS, rng), resamples=resamples)
        strengths = {one.driver: one.strength for one in rated.drivers}
        ours = [strengths[name] for name in plan.drivers]
        found.taus.append(float(stats.kendalltau(truth, [one.value for one in ours]).statistic))
        covers = [one.low <= true <= one.high for one, true in zip(ours, truth, strict=True)]
        found.covered.append(float(np.mean(covers)))
        first, second = (truth[plan.drivers.index(one.driver)] for one in rated.drivers[:2])
        found.wrong.append(bool(first < second) and headline(rated).startswith("The raters find"))
        found.agreements.append(rated.agreement)
    return found


def with_interval(values: list[float]) -> str:
    """Return a mean with its 95 % interval over sets, by Student's t."""
    half = stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)
    return f"{np.mean(values):.3f} [{np.mean(values) - half:.3f}, {np.mean(values) + half:.3f}]"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulations", type=int, default=100)
    parser.add_argument("--spread", type=float, default=2.0)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    found = simulate(given.simulations, spread=given.spread, seed=given.seed)
    print(f"{given.simulations} sets of {DRIVERS} drivers, spread {given.spread:g}, {RATERS} raters; seed {given.seed}")
    print(f"mean tau {with_interval(found.taus)}; share of intervals that cover {with_interval(found.covered)}")
    print(f"wrongly called safer than the next one: in {sum(found.wrong)} sets")
    if given.spread != 2:
        return 0
    print(f"asked for: at least {LEAST_TAU}, and {COVERED[0]} to {COVERED[1]}")
    return 0 if found.tau >= LEAST_TAU and COVERED[0] <= found.coverage <= COVERED[1] else 1


if __name__ == "__main__":
    sys.exit(main())
