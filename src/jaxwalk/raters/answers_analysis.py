"""What raters' answers say: the drivers' strengths, how far raters agree, and how far our numbers do with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.metrics.statistics import RESAMPLES
from jaxwalk.raters.agreement import alpha, with_mirrored
from jaxwalk.raters.answer_files import RaterFile
from jaxwalk.raters.preferences import ends, fit, pairs_of, resampled
from jaxwalk.raters.rating_plan import DriverMeasure, RatingPlan

FEWEST_RATERS = 5
"""Fewer raters than this give no interval: how much raters differ is unknown."""
FIRM = 0.667
"""Below this alpha, Krippendorff advises against firm conclusions."""
Agreement = Literal["unknown", "chance", "partial", "firm"]
"""How far raters agree: too little is known; not surely beyond chance; beyond it; and so far that it is usual to build
on it."""


@dataclass(frozen=True)
class RatedDriver:
    """How safe raters find a driver."""

    driver: str
    strength: Interval
    """On a logarithmic scale, whose mean over drivers is 0: a driver ahead by 1 is preferred e = 2.7 times as often as
    the other one, ties apart."""
    compared: int
    """Answers about it."""


@dataclass(frozen=True)
class MeasureAgreement:
    """How far one of our numbers orders the drivers as raters do."""

    name: str
    tau: Interval
    """Kendall's tau-b with the raters' strengths: 1 is the same order, -1 the opposite one."""
    drivers: int
    """Drivers of which the number is known."""


@dataclass(frozen=True)
class RatedDrivers:
    """The analysis."""

    plan: str
    raters: int
    """Raters who attended; the others are left out."""
    inattentive: tuple[str, ...]
    """Ids of the raters who got a check wrong, or answered none."""
    answers: int
    """Answers that count: without checks and repeated pairs."""
    ties: int
    """How many of them call neither safer."""
    agreement: Agreement
    alpha: Interval
    """Krippendorff's alpha over pairs, with the interval over pairs."""
    repeated: tuple[int, int]
    """Repeated pairs that were answered alike, and all."""
    against: int
    """Raters who contradict the ranking in more than half of their decided answers."""
    drivers: tuple[RatedDriver, ...]
    """The safest one in the raters' eyes first."""
    lead: Interval
    """By how much the first one's strength exceeds the second one's."""
    measures: tuple[MeasureAgreement, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return plain dicts, lists and numbers."""
        return asdict(self)


def analyse(plan: RatingPlan, files: Sequence[RaterFile], *, resamples: int = RESAMPLES) -> RatedDrivers:
    """Analyse raters' answers.

    Raises ValueError if no attentive rater answered anything.
    """
    kept = [one for one in files if attends(plan, one)]
    counts = count(plan, kept)
    if not counts.sum():
        raise ValueError("no rater who passed the checks answered a pair")
    samples = fit(resampled(counts, resamples=resamples), len(plan.drivers))
    ratings = _ratings(plan, kept)
    agreed = _alpha(ratings, len(kept), resamples)
    return RatedDrivers(
        plan=plan.id,
        raters=len(kept),
        inattentive=tuple(one.rater for one in files if one not in kept),
        answers=int(counts.sum()),
        ties=int(counts[..., 2].sum()),
        agreement=_agreement(agreed),
        alpha=agreed,
        repeated=_repeated(kept),
        against=_against(counts, samples[0]),
        drivers=_drivers(plan, counts, samples),
        lead=_lead(samples, len(kept)),
        measures=tuple(_measure(one, samples, len(kept)) for one in plan.measures),
    )


def attends(plan: RatingPlan, file: RaterFile) -> bool:
    """Return whether a rater got every check right that was answered, and answered one."""
    checks = [one for one in file.answers if plan.pairs[one.pair].safer is not None]
    right = [one.value == (1 if plan.pairs[one.pair].safer == "a" else -1) for one in checks]
    return bool(right) and all(right)


def count(plan: RatingPlan, files: Sequence[RaterFile]) -> Float[np.ndarray, "rater pair 3"]:
    """Return each rater's answers about every two drivers (`pairs_of`): first preferred, second preferred, neither."""
    drivers = len(plan.drivers)
    places = {tuple(pair): place for place, pair in enumerate(pairs_of(drivers).tolist())}
    counts = np.zeros((len(files), len(places), 3))
    answers = [(rater, one) for rater, file in enumerate(files) for one in file.answers if not one.repeat]
    for rater, one in answers:
        pair = plan.pairs[one.pair]
        value = one.value if pair.a < pair.b else -one.value
        place = places.get((min(pair.a, pair.b), max(pair.a, pair.b)))
        if pair.safer is None and place is not None:
            counts[rater, place, {1: 0, -1: 1, 0: 2}[value]] += 1
    return counts


def _ratings(plan: RatingPlan, files: Sequence[RaterFile]) -> Float[np.ndarray, "rater pair"]:
    """Return each rater's value of every pair of the plan; NaN where there is none."""
    found = np.full((len(files), len(plan.pairs)), np.nan)
    for rater, file in enumerate(files):
        for one in (one for one in file.answers if not one.repeat):
            found[rater, one.pair] = one.value
    return found[:, plan.rated]


def _alpha(ratings: Float[np.ndarray, "rater pair"], raters: int, resamples: int) -> Interval:
    """Return alpha with its bootstrap interval over pairs.

    Not over raters: a resample in which a rater occurs twice agrees with itself.
    """
    pairs = ratings.shape[1]
    both = with_mirrored(ratings)
    value = alpha(both)
    if np.isnan(value):
        return Interval(None, None, None)
    draws = np.random.default_rng(0).multinomial(pairs, np.full(pairs, 1 / pairs), size=resamples)
    samples = np.array([alpha(both, weights=np.tile(times, 2)) for times in draws])
    if raters < FEWEST_RATERS or np.isnan(samples).any():
        return Interval(value, None, None)
    low, high = np.quantile(samples, [0.025, 0.975]).tolist()
    return Interval(value, low, high)


def _agreement(found: Interval) -> Agreement:
    if found.value is None or found.low is None:
        return "unknown"
    if found.low <= 0:
        return "chance"
    return "firm" if found.value >= FIRM else "partial"


def _repeated(files: Sequence[RaterFile]) -> tuple[int, int]:
    alike = []
    for file in files:
        first = {one.pair: one.value for one in file.answers if not one.repeat}
        alike += [one.value == first[one.pair] for one in file.answers if one.repeat]
    return sum(alike), len(alike)


def _against(counts: Float[np.ndarray, "rater pair 3"], strengths: Float[np.ndarray, "driver"]) -> int:
    """Return how many raters contradict the strengths in more than half of their decided answers."""
    first, second = pairs_of(len(strengths)).T
    ahead = strengths[first] > strengths[second]
    with_it = np.where(ahead, counts[..., 0], counts[..., 1]).sum(axis=1)
    decided = counts[..., :2].sum(axis=(1, 2))
    return int((with_it < decided / 2).sum())


def _drivers(plan: RatingPlan, counts: np.ndarray, samples: np.ndarray) -> tuple[RatedDriver, ...]:
    raters = len(counts)
    low, high = _ends(samples, raters)
    about = counts.sum(axis=(0, 2))
    met = [int(about[(pairs_of(len(plan.drivers)) == place).any(axis=1)].sum()) for place in range(len(plan.drivers))]
    order = np.argsort(-samples[0], kind="stable").tolist()
    return tuple(RatedDriver(plan.drivers[k], _interval(samples[0, k], low[k], high[k]), met[k]) for k in order)


def _lead(samples: np.ndarray, raters: int) -> Interval:
    """Return the difference of the two largest strengths; both are of one sample, so they vary together."""
    first, second = np.argsort(-samples[0], kind="stable")[:2]
    ahead = samples[:, [first]] - samples[:, [second]]
    (low,), (high,) = _ends(ahead, raters)
    return _interval(ahead[0, 0], low, high)


def _measure(measure: DriverMeasure, samples: np.ndarray, raters: int) -> MeasureAgreement:
    """Return Kendall's tau of a measure with the strengths of all samples."""
    known = [place for place, value in enumerate(measure.values) if value is not None]
    ours = np.array([measure.values[place] for place in known], float) * (1 if measure.high else -1)
    if len(known) < 3 or len(set(ours.tolist())) < 2:
        return MeasureAgreement(measure.name, Interval(None, None, None), len(known))
    taus = np.array([[_tau(sample[known], ours)] for sample in samples])
    (low,), (high,) = _ends(taus, raters)
    return MeasureAgreement(measure.name, _interval(taus[0, 0], low, high), len(known))


def _tau(a: np.ndarray, b: np.ndarray) -> float:
    """Return Kendall's tau-b: pairs in the same order minus pairs in the opposite one, over the pairs without ties.

    NaN where all are tied.
    """
    first, second = np.triu_indices(len(a), 1)
    x, y = np.sign(a[first] - a[second]), np.sign(b[first] - b[second])
    untied = np.sqrt((x**2).sum() * (y**2).sum())
    return float((x * y).sum() / untied) if untied else float("nan")


def _ends(samples: Float[np.ndarray, "sample number"], raters: int) -> list[list[float]]:
    """Return the lower and the upper ends of numbers; NaN if there are too few raters."""
    if raters < FEWEST_RATERS:
        return [[float("nan")] * samples.shape[1]] * 2
    return ends(samples, raters).tolist()


def _interval(value: float, low: float, high: float) -> Interval:
    """Return a number with its interval; None for NaN."""
    return Interval(*(None if np.isnan(x) else float(x) for x in (value, low, high)))
