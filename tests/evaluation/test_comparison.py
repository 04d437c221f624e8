"""Two drivers compared in words."""

from __future__ import annotations

import pytest

from jaxwalk.evaluation import EndingCounts, PairedEndings, compare_endings
from jaxwalk.metrics import scenarios_needed


def comparison(both: int, only_a: int, only_b: int, p: float, scenarios: int = 10_000) -> EndingCounts:
    return EndingCounts(scenarios, both, only_a, only_b, (only_b - only_a) / scenarios, p)


def said(collision: EndingCounts, goal: EndingCounts) -> list[str]:
    pairs = PairedEndings(collision.scenarios, goal=goal, collision=collision, timeout=goal)
    return [found.in_words for found in compare_endings("old", "new", [("always-go", 0.25, pairs)])]


def test_what_is_found_is_said():
    fewer, more = said(comparison(100, 240, 110, 0.0015), comparison(9_000, 200, 500, 1e-9))
    # (Holm: twice the smaller p, and at least the other)
    assert fewer == "new collides less among always-go: 2.10 % against 3.40 %, p = 0.002, 10,000 scenarios."
    assert more == "new reaches the goal more among always-go: 95.00 % against 92.00 %, p < 0.001, 10,000 scenarios."


def test_what_is_not_found_is_said_to_be_open_and_what_it_would_take():
    open_, equal = said(comparison(10, 30, 25, 0.6), comparison(9_000, 5, 5, 1.0))
    needed = scenarios_needed(0.0040, 0.0035, both=0.001, alpha=0.05 / 2)
    assert open_.startswith("Whether new collides less among always-go is open: 0.35 % against 0.40 %, p = 1.00")
    assert open_.endswith(f"rates like these take some {float(f'{needed:.1e}'):,.0f} to tell apart.")
    assert equal == "Equally many goals of both among always-go: 90.05 % against 90.05 %, p = 1.00, 10,000 scenarios."


def test_drivers_that_did_the_same_are_said_to_have():
    equal = comparison(100, 0, 0, 1.0)
    pairs = PairedEndings(10_000, goal=equal, collision=equal, timeout=equal, alike=True)
    for found in compare_endings("old", "new", [("always-go", 0.25, pairs)]):
        assert found.in_words.endswith("p = 1.00, 10,000 scenarios; both did the same in every scenario.")


def test_p_values_are_adjusted_for_all_populations_together():
    pairs = PairedEndings(10_000, *(comparison(0, 9, 1, 0.02) for _ in range(3)))
    found = compare_endings("old", "new", [("always-go", 0.25, pairs), ("learned", 0.25, pairs)])
    assert [one.p_holm for one in found] == pytest.approx([0.08] * 4)
    assert [one.pedestrians for one in found] == ["always-go"] * 2 + ["learned"] * 2
    assert all("is open" in one.in_words for one in found)
