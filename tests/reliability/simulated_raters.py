"""Does the analysis of raters find what raters prefer? python tests/reliability/simulated_raters.py [--simulations 100]

Seven drivers of strengths with a standard deviation of 2, and 20 simulated raters of 25 pairs each, who answer by
Davidson's model. It prints the mean of Kendall's tau between the true order and the one that is found, and how many of
the 95 % intervals over raters cover the true strengths.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import stats

sys.path.insert(0, str(Path(__file__).parents[1]))

from jaxwalk.raters.answers_analysis import analyse
from raters.simulated import a_plan, files

DRIVERS, RATERS, SPREAD = 7, 20, 2.0
LEAST_TAU, COVERED = 0.9, (0.93, 0.97)
"""What is required: of the mean tau, and of the share of intervals that cover."""


@dataclass(frozen=True)
class Found:
    taus: list[float]
    covered: list[bool]
    agreements: list[str]

    @property
    def tau(self) -> float:
        return float(np.mean(self.taus))

    @property
    def coverage(self) -> float:
        return float(np.mean(self.covered))


def simulate(simulations: int, *, seed: int = 0, resamples: int = 500) -> Found:
    """Rate so many sets of drivers, each with other strengths and other raters."""
    rng = np.random.default_rng(seed)
    plan = a_plan(DRIVERS)
    found = Found([], [], [])
    for _ in range(simulations):
        truth = rng.normal(0, SPREAD, DRIVERS)
        truth -= truth.mean()
        rated = analyse(plan, files(plan, truth, RATERS, rng), resamples=resamples)
        strengths = {one.driver: one.strength for one in rated.drivers}
        ours = [strengths[name] for name in plan.drivers]
        found.taus.append(float(stats.kendalltau(truth, [one.value for one in ours]).statistic))
        found.covered.extend(bool(one.low <= true <= one.high) for one, true in zip(ours, truth, strict=True))
        found.agreements.append(rated.agreement)
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulations", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    found = simulate(given.simulations, seed=given.seed)
    print(f"{given.simulations} simulations of {DRIVERS} drivers and {RATERS} raters, seed {given.seed}")
    print(f"mean tau {found.tau:.3f}, at least {LEAST_TAU}")
    print(f"{found.coverage:.1%} of {len(found.covered)} intervals cover, {COVERED[0]:.0%} to {COVERED[1]:.0%}")
    return 0 if found.tau >= LEAST_TAU and COVERED[0] <= found.coverage <= COVERED[1] else 1


if __name__ == "__main__":
    sys.exit(main())
