"""Who is safer, from constructed results: the numbers of every case can be followed by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import pytest

from jaxwalk.evaluation.document_parts import Interval, PairedSeeds, PairedSide
from jaxwalk.metrics import proportion
from jaxwalk.report.decision import Duel, Evidence, decide, judge
from jaxwalk.report.sentences import Driven, say

SCENARIOS = 1000
DRIVEN = Driven(SCENARIOS, 3, 123.4, 4567, 12, ("paper",))


def compared(a, b, only_a, only_b, *, both=0, p=None, people="always-go", seeds=1, pairs=SCENARIOS):
    """A comparison; ``p`` is None where there are too few seeds."""
    sides = (PairedSide(name, people, (both + n) / pairs) for name, n in ((a, only_a), (b, only_b)))
    gap = (only_b - only_a) / pairs
    ends = (None, None) if p is None else (gap - 0.01, gap + 0.01)
    return PairedSeeds("hit", *sides, seeds, pairs, both, only_a, only_b, Interval(gap, *ends), p)


def evidence(*duels, hits, training="one", seeds=1, goals=0.9):
    """What is known of drivers with so many hits in a thousand scenarios, by driver and population."""
    drivers, populations = (tuple(dict.fromkeys(names)) for names in zip(*hits, strict=True))
    shares = {cell: Interval.of(proportion(count, SCENARIOS)) for cell, count in hits.items()}
    return Evidence(
        drivers, populations, shares, dict.fromkeys(hits, Interval(goals, None, None)), duels, training, seeds
    )


def two(a_hits, b_hits, p, *, training="one", seeds=1, both=0):
    found = compared("A", "B", a_hits - both, b_hits - both, both=both, p=p, seeds=seeds)
    hits = {("A", "always-go"): a_hits, ("B", "always-go"): b_hits}
    return evidence(found, hits=hits, training=training, seeds=seeds)


def said(found):
    return say(found, decide(found), DRIVEN)


def test_a_clear_winner():
    found = two(40, 10, 1e-5)
    decision, sentences = decide(found), said(found)
    assert (decision.kind, decision.leader, decision.beaten, decision.tied) == ("safest", "B", ("A",), ())
    assert [decision.standing(name) for name in "BA"] == ["safest", "less safe"]
    assert sentences.who == (
        "B is safer than A: the moving car hits somebody in 1.0 % of scenarios with B (4.0 % with A), and it arrives "
        "in 90.0 % (90.0 % with A)."
    )
    assert sentences.sure == (
        "Among always-go A hits somebody in 3.00 points more of the scenarios than B (95 % interval 2.00 to 4.00); if "
        "they were equally safe, chance would show so large a difference less than once in 1,000 such tests (p < "
        "0.001)."
    )
    assert sentences.rests == (
        "It rests on 1,000 simulated scenarios of seed 3 with 12 pedestrians each on paper, the same for every driver, "
        "among always-go people: 123 km and 4,567 encounters in all; it is about these very "
        "policies: one that was trained may turn out otherwise when trained again."
    )


@pytest.mark.parametrize(
    ("low", "high", "said_of"),
    [
        ((0.04, 0.03, 0.05), (0.01, 0.0, 0.02), True),
        ((0.04, 0.01, 0.07), (0.01, 0.0, 0.02), False),
        ((0.04, None, None), (0.01, None, None), False),
        ((None, 0.03, 0.05), (0.01, 0.0, 0.02), False),
    ],
)
def test_who_clearly_loses_time_is_said_so(low, high, said_of):
    """B is safer, and runs out of time more often and is later, if the intervals lie apart."""
    cells = {("B", "always-go"): Interval(*low), ("A", "always-go"): Interval(*high)}
    late = {cell: Interval(*(x and 100 * x for x in (one.value, one.low, one.high))) for cell, one in cells.items()}
    found = said(replace(two(40, 10, 1e-5), timeouts=cells, delays=late))
    words = "; it runs out of time in 4.0 % (1.0 % with A); its mean delay is 4.0 s (1.0 s with A)."
    assert found.who.endswith(words if said_of else "(90.0 % with A).")


def test_delays_that_point_to_both_sides_are_left_out():
    ends = {"always-go": (Interval(1.0, 0.0, 2.0), Interval(4.0, 3.0, 5.0))}
    ends["learned"] = ends["always-go"][::-1]
    delays = {(name, people): one for people, pair in ends.items() for name, one in zip("AB", pair, strict=True)}
    duels = compared("A", "B", 40, 5, p=1e-6), compared("A", "B", 40, 5, p=1e-6, people="learned")
    hits = {(name, people): count for name, count in (("A", 40), ("B", 5)) for people in ends}
    assert "delay" not in said(replace(evidence(*duels, hits=hits), delays=delays)).who


def test_no_difference():
    found = two(30, 25, 0.58)
    decision, sentences = decide(found), said(found)
    assert (decision.kind, decision.tied) == ("even", ("A",))
    assert sentences.who.startswith(
        "No difference in safety is shown between B and A: the moving car hits somebody in 2.5 % of scenarios with B"
    )
    assert (
        "Among always-go A hits somebody in 0.50 points more of the scenarios than B (95 % interval -0.50 to 1.50)"
        in sentences.sure
    )
    assert sentences.sure.endswith("scenarios (--episodes).")
    assert decision.standing("A") == "no difference shown"


def test_too_few_hits_cannot_be_judged():
    found = two(3, 0, 0.25)  # 3 scenarios: the smallest possible p-value is 2 / 2^3
    decision, sentences = decide(found), said(found)
    assert decision.kind == "unjudged"
    assert sentences.who.startswith(
        "Which of B and A is safer cannot be judged: the moving car hits somebody in 0.00 %"
    )
    assert sentences.sure == (
        "Not at all: two drivers together hit somebody at most 3 times in 1,000 scenarios, too seldom for any test; "
        "evaluate more scenarios (--episodes)."
    )
    assert decision.standing("A") == "cannot be judged"


def test_drivers_that_hit_the_same_people_are_alike():
    """Many hits, of which none is one driver's alone, are no lack of evidence."""
    assert decide(two(50, 50, 1.0, both=50)).kind == "even"


@pytest.mark.parametrize(("differing", "tests", "judged"), [(5, 1, False), (6, 1, True), (6, 2, False), (7, 2, True)])
def test_a_test_that_could_not_be_sure_judges_nothing(differing, tests, judged):
    """2 / 2^6 = 0.031 is below 0.05, but not after a correction for two comparisons."""
    assert Duel(compared("A", "B", differing, 0, p=0.03), 0.03 * tests, tests).judged == judged


def test_three_training_seeds_are_too_few():
    found = two(300, 100, None, training="few", seeds=3)
    sentences = said(found)
    assert decide(found).kind == "unjudged"
    assert "cannot be judged" in sentences.who
    assert sentences.sure == (
        "3 training seeds are too few: they don't tell how much trainings differ, and a sentence about training takes "
        "5 (--seeds 5)."
    )


@pytest.mark.parametrize(
    ("training", "seeds", "about"),
    [
        ("one", 1, "about these very policies: one that was trained may turn out otherwise when trained again"),
        ("enough", 5, "5 training seeds stand behind it, so it is about training such drivers again"),
        ("none", 0, "4,567 encounters in all"),
        (
            "unknown",
            0,
            "it isn't known whether a Python driver was trained: one that was may turn out otherwise when "
            "trained again",
        ),
    ],
)
def test_only_several_seeds_say_something_about_training(training, seeds, about):
    sentences = said(two(40, 10, 1e-5, training=training, seeds=seeds))
    assert sentences.rests.endswith(f"{about}.")
    assert ("training such drivers again" in sentences.rests) == (training == "enough")


def test_one_driver():
    found = evidence(hits={("A", "always-go"): 0, ("A", "learned"): 20})
    decision, sentences = decide(found), said(found)
    assert (decision.kind, decision.order) == ("alone", ("A",))
    assert decision.standing("A") == "compared with nobody"
    assert sentences.who == (
        "Who is safer cannot be judged, because A alone was evaluated: the moving car hits somebody in 0.00 % of "
        "scenarios with A among always-go and in 2.0 % among learned, and it arrives in 90.0 %."
    )
    # exact: 1 - 0.025^(1 / 1000) = 0.37 %; Wilson's interval of 20 in 1,000 is 1.30 to 3.07 %
    assert "between 0.00 and 0.37 % among always-go and 1.3 and 3.1 % among learned (95 % intervals)" in sentences.sure
    assert "the same for every driver" not in sentences.rests


def test_it_may_depend_on_the_people():
    first = compared("A", "B", 40, 5, p=1e-6)
    second = compared("A", "B", 5, 40, p=1e-6, people="learned")
    hits = {("A", "always-go"): 40, ("B", "always-go"): 5, ("A", "learned"): 5, ("B", "learned"): 40}
    found = evidence(first, second, hits=hits)
    assert decide(found).kind == "depends"
    assert (
        "depends on the people that they meet, B among always-go and A among learned: the moving car" in said(found).who
    )
    assert said(found).sure.startswith("The differences point to both sides: ")


def test_a_difference_among_some_people_alone_is_said_so():
    duels = compared("A", "B", 40, 5, p=1e-6), compared("A", "B", 20, 20, p=1.0, people="learned")
    hits = {("A", "always-go"): 40, ("B", "always-go"): 5, ("A", "learned"): 20, ("B", "learned"): 20}
    found = evidence(*duels, hits=hits)
    assert decide(found).kind == "safest"
    assert said(found).who.startswith(
        "B is safer than A among always-go: the moving car hits somebody in 0.50 % of scenarios with B among"
    )
    assert "among learned" not in said(found).sure


def test_the_safest_of_three_is_so_among_those_people_only_among_whom_each_test_is_sure():
    duels = [
        compared("A", "B", 5, 40, p=1e-6), compared("A", "C", 5, 60, p=1e-9), compared("B", "C", 40, 60, p=0.1),
        compared("A", "B", 20, 20, p=1.0, people="learned"), compared("A", "C", 20, 70, p=1e-6, people="learned"),
        compared("B", "C", 20, 70, p=1e-6, people="learned"),
    ]  # fmt: skip
    hits = dict(zip([(d, p) for p in ("always-go", "learned") for d in "ABC"], (5, 40, 60, 20, 20, 70), strict=True))
    found = said(evidence(*duels, hits=hits))
    assert found.who.startswith("A is the safest of 3 drivers among always-go: ")
    assert "; among the others no difference is shown; " in found.sure


def of_many(count, p):
    """Driver k has 10 k hits; ``p`` returns the p-value of two drivers."""
    names = [f"d{k}" for k in range(count)]
    duels = [compared(names[i], names[k], 10 * i, 10 * k, p=p(i, k)) for i, k in combinations(range(count), 2)]
    return evidence(*duels, hits={(name, "always-go"): 10 * k for k, name in enumerate(names)})


def test_the_safest_of_twenty():
    found = of_many(20, lambda i, k: 1e-9)
    decision, sentences = decide(found), said(found)
    assert (decision.kind, decision.leader, len(decision.beaten)) == ("safest", "d0", 19)
    assert sentences.who.startswith(
        "d0 is the safest of 20 drivers: the moving car hits somebody in 0.00 % of scenarios with d0 (1.0 % with "
        "the next, d1)"
    )
    assert sentences.sure.startswith("Among always-go d1 hits somebody in 1.00 points more of the scenarios than d0 (")
    assert sentences.sure.endswith("(p < 0.001), corrected for 190 comparisons.")
    assert len(sentences.who) < 300


def test_some_of_twenty_are_not_told_apart():
    found = of_many(20, lambda i, k: 0.9 if k < 3 else 1e-9)
    decision, sentences = decide(found), said(found)
    assert (decision.kind, decision.tied, len(decision.beaten)) == ("ahead", ("d1", "d2"), 17)
    assert sentences.who.startswith(
        "d0 is safer than 17 of the 19 other drivers; whether also than d1 and d2 is not shown: "
    )
    assert [decision.standing(name) for name in ("d0", "d2", "d3")] == [
        "among the safest", "no difference shown", "less safe",
    ]  # fmt: skip


def test_no_difference_between_twenty():
    sentences = said(of_many(20, lambda i, k: 0.9))
    assert sentences.who == (
        "No difference in safety is shown between the 20 drivers: the moving car hits somebody in 0.00 to "
        "19.0 % of scenarios, from d0 to d19, and it arrives in 90.0 to 90.0 %."
    )


def test_who_cannot_be_judged_does_not_lead():
    """Two rules are compared; of the trained driver with the fewest hits there are too few seeds."""
    duels = [compared("A", "B", 10, 100, p=1e-9), compared("A", "T", 10, 1), compared("B", "T", 100, 1)]
    hits = {("A", "always-go"): 10, ("B", "always-go"): 100, ("T", "always-go"): 1}
    decision = decide(evidence(*duels, hits=hits, training="few", seeds=3))
    assert (decision.kind, decision.leader, decision.beaten, decision.tied) == ("ahead", "A", ("B",), ("T",))
    assert decision.standing("T") == "cannot be judged"
    found = said(evidence(*duels, hits=hits, training="few", seeds=3))
    assert found.headline == "A is safer than B; whether also than T cannot be judged"
    assert found.sure.endswith("; beside T there are too few training seeds (it takes 5).")


def test_results_without_comparisons_say_so():
    found = evidence(hits={("A", "always-go"): 10, ("B", "always-go"): 100})
    assert decide(found).kind == "uncompared"
    assert "compare no drivers" in said(found).sure


def test_p_values_are_corrected_for_all_comparisons():
    duels = judge([compared("A", "B", 9, 1, p=0.02), compared("A", "C", 9, 1), compared("B", "C", 9, 1, p=0.03)])
    assert [duel.p for duel in duels] == [0.04, None, 0.04]  # Holm: 2 x 0.02, then no less
    assert [duel.tests for duel in duels] == [2, 2, 2]


def test_rare_differences_are_said_by_their_odds():
    sure = said(two(40, 20, 0.012)).sure
    assert "about once in 83 such tests (p = 0.012)" in sure
