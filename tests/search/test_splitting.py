"""Multilevel splitting on problems whose rate is known."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest
from scipy.stats import norm

from jaxwalk.metrics import proportion
from jaxwalk.search.cube import Candidates, ordinary, to_normal
from jaxwalk.search.splitting import SplittingError, SplittingPlan, pilot, rare_rate


class Plane:
    """Fails beyond a plane: the mean of the normal scores, scaled to variance 1, above a bound."""

    def __init__(self, rate: float, dimensions: int = 20, steps: float = 0.0) -> None:
        self.dimensions, self.bound, self.steps = dimensions, norm.isf(rate), steps

    def score(self, candidates: Candidates) -> np.ndarray:
        score = to_normal(candidates.points).sum(axis=1) / np.sqrt(self.dimensions) - self.bound
        if not self.steps:
            return score
        return np.where(score >= 0, score, np.floor(score / self.steps) * self.steps)  # many are equal


SMALL = SplittingPlan(particles=100, repeats=10)


@pytest.mark.parametrize("steps", [pytest.param(0.0, marks=pytest.mark.long), 0.7], ids=["smooth", "in jumps"])
def test_one_in_a_thousand_agrees_with_plain_simulation(steps):
    """In 20 repetitions, both intervals hold the true rate, and nine in ten at least overlap it."""
    rate, plain = 1e-3, 50_000
    game = Plane(rate, steps=steps)
    covered = simulated = 0
    values = []
    for seed in range(20):
        found = rare_rate(game, SMALL, seed)
        points = ordinary(np.random.default_rng([seed, 99]), plain, game.dimensions)
        counted = proportion(int((game.score(Candidates(points, np.arange(plain))) >= 0).sum()), plain)
        covered += found.low <= rate <= found.high
        simulated += counted.low <= rate <= counted.high
        values.append(found.value)
    assert covered >= 18 and simulated >= 18
    assert np.mean(values) == pytest.approx(rate, rel=0.15)


def test_one_in_a_million():
    found = [rare_rate(Plane(1e-6), SplittingPlan(particles=200, repeats=10), seed) for seed in range(4)]
    assert sum(one.low <= 1e-6 <= one.high for one in found) >= 3
    assert np.mean([one.value for one in found]) == pytest.approx(1e-6, rel=0.25)
    assert all(one.simulations < 1e6 / 8 for one in found), "plain simulation needs a million"


def test_the_same_seed_gives_the_same_rate_and_runs_are_told_of():
    told = []
    first = rare_rate(Plane(0.05), SMALL, 7, lambda run, value: told.append((run, value)))
    again = rare_rate(Plane(0.05), SMALL, 7)
    assert first == again
    assert [run for run, _ in told] == list(range(11)) and told[0][1] is None
    assert first.value == pytest.approx(np.mean([value for _, value in told[1:]]))


def test_what_never_fails_is_refused_in_words():
    class Flat:
        dimensions = 3

        def score(self, candidates):
            return np.full(len(candidates), -1.0)

    with pytest.raises(SplittingError, match="comes no nearer to a failure than a score of -1 after 0 levels"):
        rare_rate(Flat(), SMALL, 0)


def test_all_particles_step_not_only_the_copies():
    """Else the mean of the estimates wouldn't be right for few particles: survivors would stay where they are."""

    class Counted(Plane):
        played: ClassVar[list[int]] = []

        def score(self, candidates):
            self.played.append(len(candidates))
            return super().score(candidates)

    found = rare_rate(Counted(1e-2), SMALL, 0)
    assert set(Counted.played) == {SMALL.particles}
    assert sum(Counted.played) == found.simulations and len(found.levels) > 3


def test_what_fails_in_the_pilot_run_alone_has_no_rate():
    class Once(Plane):
        def score(self, candidates):
            return super().score(candidates) - 100 * (candidates.keys >= SMALL.particles)

    with pytest.raises(SplittingError, match="none of 10 estimates came to a failure; play more particles"):
        rare_rate(Once(1e-2), SMALL, 0)


def test_what_often_fails_needs_no_level():
    levels, simulations = pilot(Plane(0.9), SMALL, np.random.default_rng(0))
    assert [level.score for level in levels] == [0.0] and simulations == 100


@pytest.mark.parametrize("wrong", [{"particles": 1}, {"moves": 0}, {"repeats": 1}, {"kept": 1.0}])
def test_impossible_plans_are_refused(wrong):
    with pytest.raises(ValueError, match="splitting needs 2 particles"):
        SplittingPlan(**wrong)
