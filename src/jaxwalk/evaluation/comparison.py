"""Compare two evaluations of the same scenarios, scenario by scenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from jaxwalk.evaluation.document_parts import ComparedEnding
from jaxwalk.metrics import OUTCOMES, SURE, Rows, holm, mcnemar, scenarios_needed
from jaxwalk.metrics.outcomes import Episodes
from jaxwalk.wording import counted


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
    check_same_scenarios(rows_a, rows_b)
    a, b = rows_a[OUTCOMES], rows_b[OUTCOMES]
    return PairedEndings(
        scenarios=len(a.scenario),
        goal=_ending_counts(a.goal, b.goal),
        collision=_ending_counts(a.collision, b.collision),
        timeout=_ending_counts(~a.goal & ~a.collision, ~b.goal & ~b.collision),
        alike=_alike(a, b),
    )


def check_same_scenarios(rows_a: Rows, rows_b: Rows) -> None:
    """Raise ValueError unless both are of the same scenarios in the same order."""
    if not np.array_equal(rows_a[OUTCOMES].scenario, rows_b[OUTCOMES].scenario):
        raise ValueError("only evaluations of the same scenarios can be paired: use the same seed and episodes")


def _alike(a: Episodes, b: Episodes) -> bool:
    return all(
        np.array_equal(getattr(a, part.name), getattr(b, part.name), equal_nan=part.name == "impact_speed")
        for part in fields(Episodes)
    )


def _ending_counts(a: np.ndarray, b: np.ndarray) -> EndingCounts:
    return EndingCounts(
        scenarios=len(a),
        both=int((a & b).sum()),
        only_a=int((a & ~b).sum()),
        only_b=int((b & ~a).sum()),
        difference=float(b.mean() - a.mean()),
        p=mcnemar(a, b),
    )


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
