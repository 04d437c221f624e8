"""The answer of the study of co-training: it says what the numbers show, and when they show nothing."""

from __future__ import annotations

import pytest

from jaxwalk.evaluation import Cell, Match, Results, ScenarioSet, over_training_seeds, paired_delay, paired_over_seeds
from jaxwalk.metrics import measure, summarise
from jaxwalk.report.co_training_page import ALONE, CLEARANCE, PEOPLE, TOUCHED, answer, page
from metrics.scenes import trajectory
from report.material import HIT, REACHED

CARS = ("pure", "pure-stand-ins", "mixed", "mixed-stand-ins")
POPULATIONS = ("always-go", "gap-acceptance", *PEOPLE)


def _played(touching, scenes):
    rows = measure(trajectory(*[HIT if touching else REACHED] * scenes))
    return rows, summarise(rows, resamples=20)


PLAYED = {touching: _played(touching, 20) for touching in (True, False)}


def _results(touching, seeds):
    """Results in which the named drivers touch somebody in every scenario, the others in none."""

    def match(driver, people, seed):
        rows, summary = PLAYED[driver in touching]
        return Match(Cell(driver, people, "mode", "sample", 0.25, summary, "route", "kerb", training_seed=seed), rows)

    found = {
        (driver, people): [match(driver, people, seed) for seed in range(seeds)]
        for people in POPULATIONS
        for driver in (CLEARANCE, ALONE, *CARS)
    }
    matches = [one for group in found.values() for one in group]
    pairs = [(found[ALONE, people], found[car, people]) for people in POPULATIONS for car in CARS]
    return Results(
        ScenarioSet(20, "0123456789abcdef", 40),
        tuple(one.cell for one in matches),
        over_seeds=over_training_seeds(matches),
        paired=tuple(paired_over_seeds(TOUCHED, a, b) for a, b in pairs),
        paired_delays=tuple(paired_delay(a, b) for a, b in pairs),
    )


@pytest.mark.parametrize(
    ("touching", "verdict", "among"),
    [
        ([ALONE], "makes the car better in 16** of 16 comparisons", "`pure-stand-ins` fewer, `mixed` fewer"),
        (CARS, "makes the car worse in 16** of 16 comparisons", "`pure-stand-ins` more, `mixed` more"),
        ([ALONE, "mixed"], "makes the car better in 12** of 16 comparisons", "; `mixed` cannot be told from it"),
        (["pure"], "makes the car worse in 4** of 16 comparisons", "`mixed`, `mixed-stand-ins` cannot be told"),
    ],
)
def test_the_answer_follows_from_the_numbers(touching, verdict, among):
    said = answer(_results(touching, 5))
    assert said.startswith(f"**Co-training {verdict}")
    for people in POPULATIONS:
        assert f"Among {people}: `pure`" in said
    assert among in said
    share = "100.00" if ALONE in touching else "0.00"
    assert f"the car alone touches somebody in {share} [" in said


def test_no_difference_is_no_effect_shown():
    said = answer(_results([], 5))
    assert said.startswith("**No effect of co-training is shown** in any of 16 comparisons")
    assert said.count("`mixed-stand-ins` cannot be told from it (intervals within ") == 4


def test_four_seeds_judge_nothing():
    results = _results([ALONE], 4)
    assert "cannot be judged**: there are 4 training seeds" in answer(results)
    text = page(results, updates=3)
    assert answer(results) in text
    assert text.count("| cannot be judged | cannot be judged |") == 32


def test_a_difference_of_delays_is_that_of_the_cars_that_arrive():
    """Nobody's unhindered time is known here, so no delay exists."""
    found = _results([], 5).paired_delays[0]
    assert (found.pairs, found.difference.value, found.p) == (0, None, None)
