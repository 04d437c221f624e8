"""Compare two evaluations of the same scenarios, scenario by scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
from jaxtyping import Int, Shaped

from jaxwalk.evaluation.document_parts import ComparedEnding
from jaxwalk.metrics import OUTCOMES, SURE, Rows, holm, scenarios_needed
from jaxwalk.metrics.metric import added_up
from jaxwalk.metrics.outcomes import Episodes
from jaxwalk.metrics.paired_tests import mcnemar_of_counts
from jaxwalk.metrics.values import Values
from jaxwalk.wording import counted

T = TypeVar("T")


@dataclass(frozen=True)
class EndingCounts:
    """How often one kind of ending happens in A and in B."""

    scenarios: int
    both: int
    """Number of scenarios with this ending in both."""
    only_a: int
    only_b: int
    difference: float
    """Share in B minus share in A."""
    p: float
    """Exact McNemar p-value, two-sided."""

    @property
    def rates(self) -> tuple[float, float]:
        """Shares with this ending in A and in B."""
        return (self.both + self.only_a) / self.scenarios, (self.both + self.only_b) / self.scenarios


@dataclass(frozen=True)
class PairedEndings:
    """The endings of the same scenarios under A and under B."""

    scenarios: int
    goal: EndingCounts
    collision: EndingCounts
    timeout: EndingCounts
    alike: bool = False
    """Whether an episode's record (`Episodes`) is equal in every scenario, down to the length of the path."""


def paired(rows_a: Rows, rows_b: Rows) -> PairedEndings:
    """Compare two evaluations of the same scenarios (the same seed, and the same street except for what is compared).

    Raises:
        ValueError: the scenarios differ, or are in another order.
    """
    pairs = PairedRows(rows_a, rows_b)
    counts = pairs.total(lambda a, b: np.stack([joint_counts(*both) for both in _endings(a[OUTCOMES], b[OUTCOMES])]))
    goal, collision, timeout = (_ending_counts(pairs.episodes, *found) for found in counts.tolist())
    alike = all(_alike(a[OUTCOMES], b[OUTCOMES]) for a, b in pairs.chunks())
    return PairedEndings(pairs.episodes, goal, collision, timeout, alike)


@dataclass(frozen=True)
class PairedRows:
    """Rows of the same scenarios in the same order. Raises ValueError if they aren't."""

    a: Rows
    b: Rows

    def __post_init__(self) -> None:
        check_same_scenarios(self.a, self.b)

    @property
    def episodes(self) -> int:
        """Number of scenarios."""
        return self.a.episodes

    def chunks(self) -> Iterator[tuple[Rows, Rows]]:
        """Yield the rows of the same scenarios, as `Rows.chunks` does."""
        return zip(self.a.chunks(), self.b.chunks(), strict=True)

    def total(self, formula: Callable[[Rows, Rows], T]) -> T:
        """Return what `Rows.total` does, for a formula of both."""
        return added_up(formula(a, b) for a, b in self.chunks())

    def values(self, formula: Callable[[Rows, Rows], Shaped[np.ndarray, "_"]]) -> Values:
        """Return what `Rows.values` does, for a formula of both."""
        return Values(lambda: (formula(a, b) for a, b in self.chunks()))


def check_same_scenarios(rows_a: Rows, rows_b: Rows) -> None:
    """Raise ValueError unless both are of the same scenarios in the same order."""
    pairs = zip(rows_a.chunks(), rows_b.chunks(), strict=False)
    same = (np.array_equal(a[OUTCOMES].scenario, b[OUTCOMES].scenario) for a, b in pairs)
    if rows_a.episodes != rows_b.episodes or not all(same):
        raise ValueError("only evaluations of the same scenarios can be paired: use the same seed and episodes")


def _endings(a: Episodes, b: Episodes) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return in which episodes of both there is a goal, a collision, a timeout."""
    return [(a.goal, b.goal), (a.collision, b.collision), (~a.goal & ~a.collision, ~b.goal & ~b.collision)]


def joint_counts(a: np.ndarray, b: np.ndarray) -> Int[np.ndarray, "3"]:
    """Return in how many episodes something is so in both, in A alone, and in B alone."""
    return np.array([(a & b).sum(), (a & ~b).sum(), (b & ~a).sum()])


def _alike(a: Episodes, b: Episodes) -> bool:
    return all(
        np.array_equal(getattr(a, part.name), getattr(b, part.name), equal_nan=part.name == "impact_speed")
        for part in fields(Episodes)
    )


def _ending_counts(scenarios: int, both: int, only_a: int, only_b: int) -> EndingCounts:
    difference = (both + only_b) / scenarios - (both + only_a) / scenarios
    return EndingCounts(scenarios, both, only_a, only_b, difference, mcnemar_of_counts(only_a, only_b))


SAID = {"collision": ("collides less", "collides more"), "goal": ("reaches the goal less", "reaches the goal more")}
"""Words for an ending that is rarer in B, and for one that is more frequent."""
ALIKE = "both did the same in every scenario"
"""What is said beside p-values of 1, which alone would leave open whether two drivers differ at all."""


def compare_endings(a: str, b: str, among: Sequence[tuple[str, float, PairedEndings]]) -> tuple[ComparedEnding, ...]:
    """Test collisions and goals of two drivers in pairs, and describe the findings in words.

    The p-values are adjusted for the number of tests (Holm).

    Args:
        a: name of driver A in all pairs.
        b: name of driver B.
        among: name of each population, jaywalk multiplier, and pairs.
    """
    tests = [
        (people, multiplier, ending, found, pairs.alike)
        for people, multiplier, pairs in among
        for ending, found in (("collision", pairs.collision), ("goal", pairs.goal))
    ]
    adjusted = holm([found.p for *_, found, _ in tests])
    return tuple(
        ComparedEnding(
            a=a,
            b=b,
            pedestrians=people,
            jaywalk_multiplier=multiplier,
            ending=ending,
            rate_a=found.rates[0],
            rate_b=found.rates[1],
            only_a=found.only_a,
            only_b=found.only_b,
            scenarios=found.scenarios,
            p=found.p,
            p_holm=p,
            in_words=_in_words(b, people, ending, found, p, len(tests)) + (f"; {ALIKE}." if alike else "."),
        )
        for (people, multiplier, ending, found, alike), p in zip(tests, adjusted, strict=True)
    )


def _in_words(b: str, people: str, ending: str, found: EndingCounts, p: float, tests: int) -> str:
    """Return, say, ``B collides less among always-go: 2.1 % against 3.4 %, p = 0.003, 10,000 scenarios``."""
    (rate_a, rate_b), (less, more) = found.rates, SAID[ending]
    side = less if rate_b < rate_a else more
    chance = "p < 0.001" if p < 0.001 else f"p = {p:.3f}" if p < 0.1 else f"p = {p:.2f}"
    numbers = f"{100 * rate_b:.2f} % against {100 * rate_a:.2f} %, {chance}, {counted(found.scenarios, 'scenario')}"
    if p < SURE:
        return f"{b} {side} among {people}: {numbers}"
    if rate_a == rate_b:
        return f"Equally many {ending}s of both among {people}: {numbers}"
    # One test of a family has to reach this p-value, since Holm's correction asks no more of the smallest one.
    needed = scenarios_needed(rate_a, rate_b, both=found.both / found.scenarios, alpha=SURE / tests)
    enough = f"rates like these take some {float(f'{needed:.1e}'):,.0f} to tell apart"
    return f"Whether {b} {side} among {people} is open: {numbers}; {enough}"
