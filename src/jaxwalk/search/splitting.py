"""Multilevel splitting: the unbiased rate of rare failures (Kahn and Harris, 1951; Norden, O'Kelly and Sinha, 2019).

A failure is reached over levels that are each likely from the one before: particles above a level replace those below,
and all step on above it, as `jaxwalk.search.cube.stepped` does. The rate is the product of the shares that pass each
level. A pilot run chooses levels and step sizes; all others take them as given, so each of their estimates has the
right mean, whatever the number of particles and however badly they mix (Del Moral, 2004, theorem 7.4.2). If only the
copies stepped, as is often done, the mean would be wrong for few particles that mix badly. Scores may jump, and many
may be equal: a level is passed by who has its score or more, and shares are counted.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy
from jaxtyping import Bool, Float

from jaxwalk.search.cube import Candidates, Scored, ordinary, stepped

FAILURE = 0.0
"""The last level: this score or more is a failure."""
WANTED = 0.3
"""The pilot run seeks steps of which this share is accepted."""
MOST_LEVELS = 100
"""Most levels of a pilot run: rates down to 1e-30 need fewer."""


class SplittingError(ValueError):
    """Too few particles to come to a failure."""


@dataclass(frozen=True)
class SplittingPlan:
    """How much to play. Raises ValueError for impossible numbers."""

    particles: int = 256
    kept: float = 0.5
    """Share of the particles that passes a level of the pilot run."""
    moves: int = 2
    """Steps of each particle at each level."""
    repeats: int = 10
    """Estimates, whose mean is the rate; the interval is of their spread."""

    def __post_init__(self) -> None:
        """Refuse impossible numbers."""
        if self.particles < 2 or self.moves < 1 or self.repeats < 2 or not 0 < self.kept < 1:
            raise ValueError("splitting needs 2 particles, 1 move and 2 repeats or more, and kept between 0 and 1")


@dataclass(frozen=True)
class Level:
    """A score to pass, and how particles step above it."""

    score: float
    far: float = 0.5
    """How far all numbers step: sqrt(1 - rho^2)."""
    share: float = 0.2
    """Which share of the numbers is drawn anew, in every other step."""


@dataclass(frozen=True)
class RareRate:
    """The rate of failures."""

    value: float
    """Mean of the estimates."""
    low: float
    """The lower end of the 95 % t-interval for the mean; not below 0."""
    high: float
    estimates: tuple[float, ...]
    levels: tuple[Level, ...]
    simulations: int
    """Number of scenarios played, those of the pilot run included."""

    @staticmethod
    def of(estimates: list[float], levels: tuple[Level, ...], simulations: int) -> RareRate:
        """Return the rate by two or more estimates."""
        mean, count = float(np.mean(estimates)), len(estimates)
        half = float(scipy.stats.t.ppf(0.975, count - 1) * np.std(estimates, ddof=1) / math.sqrt(count))
        return RareRate(mean, max(0.0, mean - half), mean + half, tuple(estimates), levels, simulations)


@dataclass
class Swarm:
    """The particles of a run."""

    game: Scored
    rng: np.random.Generator
    candidates: Candidates
    scores: Float[np.ndarray, "particle"]
    simulations: int = 0

    @staticmethod
    def begin(game: Scored, rng: np.random.Generator, count: int, run: int) -> Swarm:
        """Return ordinary particles, with keys that no other run has."""
        candidates = Candidates(ordinary(rng, count, game.dimensions), run * count + np.arange(count))
        return Swarm(game, rng, candidates, game.score(candidates), count)

    def replace(self, passes: Bool[np.ndarray, "particle"]) -> None:
        """Replace who doesn't pass by copies of others."""
        source = np.arange(len(passes))
        source[~passes] = self.rng.choice(np.flatnonzero(passes), int((~passes).sum()))
        self.candidates, self.scores = self.candidates.some(source), self.scores[source]

    def move(self, level: Level, *, anew: bool) -> float:
        """Let all particles make a step, if they stay above the level; return which share did.

        ``anew``: draw some of the numbers anew, else step a little in all of them.
        """
        points = self.candidates.points
        if anew:
            stepping = stepped(self.rng, points, 0.0, self.rng.random(points.shape) < level.share)
        else:
            stepping = stepped(self.rng, points, math.sqrt(1 - level.far**2))
        scores = self.game.score(Candidates(stepping, self.candidates.keys))
        self.simulations += len(scores)
        accepted = scores >= level.score
        points[accepted], self.scores[accepted] = stepping[accepted], scores[accepted]
        return float(accepted.mean())


def pilot(game: Scored, plan: SplittingPlan, rng: np.random.Generator) -> tuple[tuple[Level, ...], int]:
    """Choose levels and step sizes; return them, and how many scenarios it took.

    Raise SplittingError if it comes no nearer to a failure.
    """
    swarm, levels = Swarm.begin(game, rng, plan.particles, 0), []
    before = Level(-math.inf)
    while True:
        score = _next_level(swarm.scores, plan.kept)
        if score is not None and score >= FAILURE:
            break
        if len(levels) == MOST_LEVELS or score is None:
            best = float(swarm.scores.max())
            raise SplittingError(
                f"splitting comes no nearer to a failure than a score of {best:.3g} after {len(levels)} levels; "
                "play more particles, or search for failures first"
            )
        swarm.replace(swarm.scores >= score)
        level = Level(score, before.far, before.share)
        for number in range(plan.moves):
            level = _adapted(level, swarm.move(level, anew=number % 2 == 1), anew=number % 2 == 1)
        levels.append(level)
        before = level
    return (*levels, Level(FAILURE)), swarm.simulations


def estimate(
    game: Scored, levels: tuple[Level, ...], plan: SplittingPlan, rng: np.random.Generator, run: int
) -> tuple[float, int]:
    """Return an unbiased estimate of the rate by given levels, and how many scenarios it took.

    ``run`` numbers the runs from 1, so that each has keys of its own.
    """
    swarm, rate = Swarm.begin(game, rng, plan.particles, run), 1.0
    for level in levels:
        passes = swarm.scores >= level.score
        rate *= float(passes.mean())
        if not passes.any() or level.score >= FAILURE:
            break
        swarm.replace(passes)
        for number in range(plan.moves):
            swarm.move(level, anew=number % 2 == 1)
    return rate, swarm.simulations


def rare_rate(
    game: Scored, plan: SplittingPlan, seed: int, tell: Callable[[int, float | None], None] = lambda *_: None
) -> RareRate:
    """Return the rate of failures.

    Args:
        game: what is played.
        plan: how much.
        seed: of chance; the same seed gives the same rate.
        tell: called with the number of the run that has ended (0: the pilot run), and its estimate.

    Raises:
        SplittingError: no run, or only the pilot run, comes to a failure.
    """
    levels, simulations = pilot(game, plan, np.random.default_rng([seed, 0]))
    tell(0, None)
    estimates: list[float] = []
    for run in range(1, plan.repeats + 1):
        found, played = estimate(game, levels, plan, np.random.default_rng([seed, run]), run)
        estimates.append(found)
        simulations += played
        tell(run, found)
    if not any(estimates):
        raise SplittingError(f"none of {plan.repeats} estimates came to a failure; play more particles")
    return RareRate.of(estimates, levels, simulations)


def _next_level(scores: Float[np.ndarray, "particle"], kept: float) -> float | None:
    """Return the score that a share of the particles has or exceeds, but not everybody.

    None if all are equal and below a failure.
    """
    above = scores[scores > scores.min()]
    if not len(above):
        return None if scores.min() < FAILURE else FAILURE
    return max(float(np.sort(scores)[int((1 - kept) * len(scores))]), float(above.min()))


def _adapted(level: Level, accepted: float, *, anew: bool) -> Level:
    """Return the level with a longer step if many were accepted, or a shorter one."""
    change = math.exp(accepted - WANTED)
    if anew:
        return replace(level, share=min(1.0, max(1e-3, level.share * change)))
    return replace(level, far=min(0.99, max(0.01, level.far * change)))
