"""Numbers over training seeds agree with those of one; pairs are of the same scenarios."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from jaxwalk.evaluation import Match, over_training_seeds, paired, paired_delay, paired_over_seeds
from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.training_seeds import SEED_RATIOS
from jaxwalk.metrics import OUTCOMES, Estimate, OverSeeds, crossed_mean, mcnemar, over_seeds, paired_difference
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.metrics.delay import delays


@pytest.fixture(scope="module")
def matches(compared):
    """Route-follower and random among always-go, as if they were one driver trained with seeds 3 to 7."""
    results, rows = compared
    cells = {name: results.cell(name, "always-go") for name in ("route-follower", "random")}
    trained = [(3, "route-follower"), (4, "random"), (5, "route-follower"), (6, "random"), (7, "random")]
    return [
        Match(dataclasses.replace(cells[name], driver="learner", training_seed=seed), rows[name, "always-go"])
        for seed, name in trained
    ]


@pytest.mark.parametrize("name", SEED_RATIOS)
def test_every_measure_is_the_cells(matches, name):
    measure = SEED_RATIOS[name]
    for match in matches:
        over, under = measure.parts(match.rows)
        expected = measure.of_one(match.cell.summary).value
        assert over_seeds(over[None], under[None]).each == (pytest.approx(expected),)


def test_numbers_over_seeds(matches):
    (found,) = over_training_seeds(matches)
    names = ["driver", "pedestrians", "jaywalk_multiplier", "training_seeds"]
    document = dataclasses.asdict(found)
    assert list(document) == [*names, *SEED_RATIOS]
    assert [document[name] for name in names] == ["learner", "always-go", 0.25, (3, 4, 5, 6, 7)]
    goal = found.goal_rate
    rates = [match.rows[OUTCOMES].goal.mean() for match in matches]
    assert list(goal.each) == pytest.approx(rates)
    assert goal.mean.value == pytest.approx(sum(rates) / 5)
    assert goal.mean.low < goal.mean.value < goal.mean.high
    json.dumps(document, allow_nan=False)


def test_one_seed_keeps_the_cells_intervals(matches):
    (found,) = over_training_seeds(matches[:1])
    rate = matches[0].cell.summary[OUTCOMES].goal
    assert found.goal_rate.mean == Estimate(rate.value, rate.low, rate.high, 1)
    assert found.goal_rate.iqm == rate.value


def test_what_never_happens_has_the_interval_of_one_seed(matches):
    """Five zeros have no spread; an interval without a width would say that the rate is known to be none."""
    follower = matches[0]
    rate = follower.cell.summary[OUTCOMES].timeout
    assert rate.value == 0
    cells = [dataclasses.replace(follower.cell, training_seed=seed) for seed in range(5)]
    (found,) = over_training_seeds([Match(cell, follower.rows) for cell in cells])
    never = found.timeout_rate
    assert never == OverSeeds(Estimate(0.0, 0.0, rate.high, 5), 0.0, (0.0,) * 5)
    assert rate.high > 0.1


def test_a_cell_tells_its_training_seed(matches):
    document = matches[1].cell.as_dict()
    assert list(document)[:4] == ["driver", "pedestrians", "training_seed", "driver_mode"]
    assert document["training_seed"] == 4
    assert document["episodes"] == 24


def test_one_pair_of_policies_has_mcnemars_test(matches, rows):
    follower, random = matches[:2]
    one = paired_over_seeds("goal", [follower], [random])
    ends = [match.rows[OUTCOMES].goal for match in (follower, random)]
    expected = paired(follower.rows, random.rows).goal
    assert (one.only_a, one.only_b, one.p) == (expected.only_a, expected.only_b, expected.p)
    assert one.difference == Interval.of(paired_difference(*ends))
    assert one.difference.value == pytest.approx(one.b.rate - one.a.rate)
    with pytest.raises(ValueError, match="same scenarios"):
        paired_over_seeds("goal", [follower], [dataclasses.replace(random, rows=rows)])


def test_several_seeds_are_compared_over_seeds(matches):
    """The only match of A stands for every seed of B: against itself it differs in nothing."""
    follower, random = matches[:2]
    found = paired_over_seeds("goal", [follower], matches)
    once = paired(follower.rows, random.rows).goal
    assert (found.training_seeds, found.pairs) == (5, 120)
    assert (found.only_a, found.only_b) == (3 * once.only_a, 3 * once.only_b)
    goals = np.stack([match.rows[OUTCOMES].goal for match in matches]).astype(float)
    expected = crossed_mean(goals - goals[0])
    assert (found.difference.low, found.difference.high) == (max(expected.ends()[0], -1), expected.ends()[1])
    assert found.p == expected.p() > 0.05
    # as if every pair were independent: three times the evidence of one
    assert mcnemar(np.tile(goals[0] > 0, 5), goals.reshape(-1) > 0) < 1e-6


def test_delays_are_compared_where_both_arrive(matches):
    follower = matches[0]
    found = paired_delay([follower], matches)
    late = [delays(match.rows) - delays(follower.rows) for match in matches]
    both = [~np.isnan(each) for each in late]
    assert (found.training_seeds, found.pairs) == (5, sum(each.sum() for each in both))
    assert found.difference.value == pytest.approx(np.mean([np.nanmean(each) for each in late]))
    assert found.difference.low < found.difference.value < found.difference.high
    excludes = not found.difference.low <= 0 <= found.difference.high
    assert (found.p < 0.05) == excludes
    few = paired_delay([follower], matches[:4])
    assert (few.difference.low, few.p) == (None, None)


def test_contacts_of_the_moving_car_are_compared(matches):
    """They are those by footprint, whatever ends the episodes."""
    follower, random = matches[:2]
    found = paired_over_seeds("moving contact", [follower], [random])
    sides = [match.cell.summary[MEASURED_CONTACTS].footprint.moving for match in (follower, random)]
    assert (found.a.rate, found.b.rate) == (sides[0].value, sides[1].value)
    assert found.both + found.only_a == sides[0].successes
    assert 0 < sides[0].successes < 24


def test_few_seeds_are_not_judged(matches):
    found = paired_over_seeds("goal", matches[:1], matches[:4])
    assert (found.difference.low, found.difference.high, found.p) == (None, None, None)
    assert found.difference.value == pytest.approx(found.b.rate - found.a.rate)


def test_equal_seeds_are_one_pair(matches):
    """Seeds that end alike in every scenario are no further evidence."""
    follower = matches[0]
    found = paired_over_seeds("collision", [follower] * 5, [follower] * 5)
    assert (found.p, found.difference.value) == (1, 0)
    assert found.difference.low == -found.difference.high < 0


def test_only_equal_seeds_are_paired(matches):
    """Pair (seed, scenario) would otherwise have one seed's A and another's B."""
    for other in (matches[:2], matches[::-1]):
        with pytest.raises(ValueError, match=r"A has the training seeds \[3, 4, 5, 6, 7\] and B \[.*3\b.*\]"):
            paired_over_seeds("goal", matches, other)
