"""The page of hidden intent: what it says follows from the numbers."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from jaxwalk.evaluation import Cell, Match, Results, ScenarioSet, over_training_seeds, paired_delay, paired_over_seeds
from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.equal_delay import EqualDelay, equal_delay
from jaxwalk.evaluation.harm_numbers import paired_harm, seed_harms
from jaxwalk.metrics import DELAY, OUTCOMES, measure, summarise
from jaxwalk.metrics.injury import monfort_mueller_mais3
from jaxwalk.report.intent_document import IntentStreet
from jaxwalk.report.intent_page import ENDINGS, answer, compared
from jaxwalk.report.seed_tables import harm_table
from jaxwalk.report.table import MOVING
from metrics.scenes import Scene, Walk, trajectory

HIT, NOBODY = Walk(2.0, 0.0), Walk(0.0, 50.0)
EPISODES = 10


def _match(driver: str, seed: int, hits: int, speed: float = 10.0) -> Match:
    """Ten episodes, of which the first ones end with a contact at this speed; in the others the car arrives."""
    hit, free = Scene(4, [HIT], speed=speed, touched=[0]), Scene(4, [NOBODY], goal=True)
    rows = measure(trajectory(*[hit] * hits, *[free] * (EPISODES - hits)))
    cell = Cell(driver, "always-go", "mode", "mode", 0.25, summarise(rows, resamples=20), "route", "kerb")
    return Match(replace(cell, training_seed=seed), rows)


@cache
def _street(seeds: int) -> IntentStreet:
    """The blind car touches 4 to 6 people in ten episodes, ``x-ray`` none or one, ``told`` as many as the blind one."""
    of = {
        "blind": [_match("blind", seed, 4 + seed % 3) for seed in range(seeds)],
        "x-ray": [_match("x-ray", seed, seed % 2) for seed in range(seeds)],
        "told": [_match("told", seed, 6 - seed % 3) for seed in range(seeds)],
    }
    matches = [match for group in of.values() for match in group]
    blind, others = of["blind"], (of["x-ray"], of["told"])
    results = Results(
        ScenarioSet(EPISODES, "0123456789abcdef", 110),
        tuple(match.cell for match in matches),
        over_seeds=over_training_seeds(matches),
        paired=tuple(paired_over_seeds(end, blind, other) for end in ENDINGS for other in others),
        paired_delays=tuple(paired_delay(blind, other) for other in others),
    )
    harms = seed_harms("serious injuries", matches)
    paired = tuple(paired_harm("serious injuries", blind, other) for other in others)
    return IntentStreet("jaywalk multiplier 1", results, (), harms, paired, ())


def test_the_answer_names_what_helps_and_what_is_not_shown_to():
    """Whoever isn't touched arrives here, so goals are as many more as contacts are fewer."""
    about, x_ray, told = answer(_street(5)).split("\n\n", 1)[0], *answer(_street(5)).split("\n- ")[1:]
    assert about.startswith(
        "With jaywalk multiplier 1, the moving car of `blind` touches somebody in 48.00 % of the scenarios, and "
        "52.00 % end at the goal."
    )
    assert x_ray.startswith("`x-ray` touches somebody in fewer scenarios than `blind`: -44.00 [-")
    assert ". Goals +44.00 [" in x_ray and "delay –" in x_ray
    assert told.startswith("`told` is not shown to differ from `blind`: +4.00 [-")
    assert "equal delay" not in answer(_street(5))


@pytest.mark.parametrize(
    ("p", "verdict"), [(0.01, "touches somebody in fewer scenarios than"), (0.03, "is not shown to differ from")]
)
def test_the_answer_ends_with_equal_delay(p, verdict):
    """Two tests: Holm doubles the smaller p-value."""
    found = EqualDelay(MOVING, "blind", "told", 3, 5, 0.1, -2.0, -1.0, Interval(-1.5, -2.5, -0.5), p)
    said = answer(replace(_street(5), equal_delays=(found, replace(found, of="serious injuries in 1,000", p=0.9))))
    assert said.count("At equal delay") == 1
    assert said.endswith(f"- At equal delay `told` {verdict} `blind`: -1.50 [-2.50, -0.50] points, p = {2 * p:.3f}.")


@pytest.mark.parametrize("seeds", [1, 4])
def test_too_few_seeds_judge_nothing(seeds):
    """Not even one, whose pairs have a test over scenarios."""
    assert answer(_street(seeds)).startswith("**What hidden intent costs cannot be judged**")


def test_a_car_alone_is_compared_with_nobody():
    nothing = replace(_street(1), results=replace(_street(1).results, paired=()))
    assert answer(nothing) == "**Nothing was compared**: only `blind` was trained."


def test_who_is_compared_with_whom():
    assert compared(["blind", "x-ray", "told"]) == [("blind", "x-ray"), ("blind", "told")]
    pairs = compared(["blind", "placebo", "belief", "told", "memory"])
    assert pairs[:4] == [("blind", name) for name in ("placebo", "belief", "told", "memory")]
    assert pairs[4:] == [("placebo", "belief"), ("placebo", "told")]


def test_injuries_by_hand():
    """Every contact at 10 m/s has the risk of Monfort and Mueller's curve: 4.8 of ten episodes of the blind car."""
    street, risk = _street(5), float(monfort_mueller_mais3(10.0))
    blind, x_ray, _ = street.harms
    assert blind.number.mean.value == pytest.approx(1000 * 0.48 * risk, rel=1e-5)
    assert x_ray.number.mean.value == pytest.approx(1000 * 0.04 * risk, rel=1e-5)
    assert street.paired_harms[0].difference.value == pytest.approx(-440 * risk, rel=1e-5)
    row = harm_table(street.paired_harms).rows[0]
    assert row[:3] == ("serious injuries in 1,000", "blind", "x-ray")


def _delayed(driver: str, seed: int, hits: int, delay: float) -> Match:
    """The car arrives this much later than it would without people."""
    match = _match(driver, seed, hits)
    match.rows[DELAY].time[:] = match.rows[OUTCOMES].steps * match.rows.dt - delay
    return match


def test_equal_delay_by_hand():
    """A touches 4 people a second late and 2 two seconds late: 20 points a second. B touches 3 and 1, but 2 and 3 s
    late: 10 points fewer on average, 10 points more than A if it were as quick.
    """
    a = [[_delayed("blind", seed, hits, late) for seed in range(2)] for hits, late in ((4, 1.0), (2, 2.0))]
    b = [[_delayed("told", seed, hits, late) for seed in range(2)] for hits, late in ((3, 2.0), (1, 3.0))]
    found = equal_delay("moving contacts %", a, b)
    assert (found.a, found.b, found.prices, found.training_seeds) == ("blind", "told", 2, 2)
    assert found.later == pytest.approx(1.0, abs=1e-5)
    assert (found.slope_a, found.slope_b) == (pytest.approx(-20, abs=1e-4), pytest.approx(-20, abs=1e-4))
    assert found.difference.value == pytest.approx(10, abs=1e-4)
    assert (found.difference.low, found.p) == (None, None), "two seeds judge nothing"


def test_equal_delay_needs_delays_and_the_same_seeds():
    a, b = ([[_match(name, seed, hits) for seed in range(2)] for hits in (1, 2)] for name in ("blind", "told"))
    found = equal_delay("serious injuries in 1,000", a, b)
    assert (found.later, found.difference.value, found.slope_a, found.p) == (None, None, None, None)
    with pytest.raises(ValueError, match="the same training seeds"):
        equal_delay("moving contacts %", a, [group[:1] for group in b])
