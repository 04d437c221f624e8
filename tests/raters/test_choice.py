"""Which scenarios raters see, from hand-made episodes."""

from __future__ import annotations

import dataclasses

import pytest

from jaxwalk.metrics import measure, summarise
from jaxwalk.raters import RatingError
from jaxwalk.raters.rating_choice import choose_pairs, measures_of
from jaxwalk.raters.rating_page import clips_of
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, trajectory
from raters.simulated import a_plan

PASSER = Walk(40.0, -4.0, vy=1.0, crossings=[(10, 45, CROSSWALK)])
MEETS = Scene(50, [PASSER], goal=True)
ALONE = Scene(50, [Walk(90.0, 20.0)], goal=True)
HIT = Scene(50, [Walk(25.0, 0.0, crossings=[(20, 50, JAYWALK)])], touched=[0])


def rows(*scenes):
    return measure(trajectory(*scenes))


def test_pairs_are_of_scenarios_with_an_encounter_and_checks_of_hits():
    careful = rows(ALONE, ALONE, MEETS, MEETS, MEETS)
    blind = rows(HIT, HIT, MEETS, MEETS, MEETS)
    found = choose_pairs({"careful": careful, "other": careful, "blind": blind}, 2, each=3, seed=0)
    rated, checks = [pair for pair in found if not pair.safer], [pair for pair in found if pair.safer]
    assert sorted(pair.scenario for pair in rated) == [2, 3, 4]
    assert {frozenset((pair.a, pair.b)) for pair in rated} == {frozenset((0, 1))}
    assert len({pair.start for pair in rated}) == 1 and rated[0].start >= 0
    assert sorted(pair.scenario for pair in checks) == [0, 1]
    for pair in checks:
        assert (pair.b if pair.safer == "a" else pair.a) == 2  # the blind one is not the safer one
        assert pair.start == 0.0  # the hit is after 5.0 s
    assert [pair.safer for pair in checks] == ["a", "b"]
    assert found == choose_pairs({"careful": careful, "other": careful, "blind": blind}, 2, each=3, seed=0)


def test_what_is_missing_is_said():
    quiet = rows(ALONE, ALONE, ALONE)
    with pytest.raises(
        RatingError, match="a and b meet somebody in 0 scenarios, and 3 are needed; take more --episodes"
    ):
        choose_pairs({"a": quiet, "b": quiet}, 2, each=3, seed=0)
    busy = rows(MEETS, MEETS, MEETS)
    with pytest.raises(RatingError, match="only 0 of 2 checks can be made"):
        choose_pairs({"a": busy, "b": busy}, 2, each=3, seed=0)


def test_both_clips_begin_while_their_episodes_go_on():
    """In half a second the one car is at its goal, and only then the other one meets somebody."""
    soon = rows(*[Scene(5, [Walk(90.0, 20.0)], goal=True)] * 3)
    with pytest.raises(RatingError, match="a and b meet somebody in 0 scenarios"):
        choose_pairs({"a": soon, "b": rows(MEETS, MEETS, MEETS)}, 2, each=3, seed=0)


def test_our_numbers_are_those_of_each_driver():
    found = {
        one.name: one
        for one in measures_of([summarise(rows(HIT, ALONE), resamples=20), summarise(rows(ALONE, ALONE), resamples=20)])
    }
    assert found["hits"].values == (0.5, 0.0)
    assert not found["hits"].high and found["delay"].high


def test_each_clip_is_there_once():
    plan = a_plan(3)
    twice = dataclasses.replace(plan, pairs=plan.pairs * 2)
    assert clips_of(twice) == clips_of(plan)
    assert len(clips_of(plan)) == 2 * len(plan.pairs)  # every pair has a scenario of its own
