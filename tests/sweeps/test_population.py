"""Who goes on from whose checkpoint, and with which values."""

from __future__ import annotations

import random

import pytest

from jaxwalk.sweeps.population import EndedMember, ExtinctError, Population, PopulationPlan, drawn
from jaxwalk.sweeps.varied import ListedValues, ValueRange

RATE = {"rate": ValueRange(1e-4, 1e-2, log=True)}


def population(fields=RATE, seed=5, **changes):
    usual = {"members": 8, "generations": 3, "resample": 0.0}
    return Population(PopulationPlan(**usual | changes), fields, True, seed)


def ended(values, labels=None, first=0):
    labels = labels or [{"rate": 1e-3 + 1e-5 * k} for k in range(len(values))]
    return [EndedMember(first + k, labels[k], value) for k, value in enumerate(values)]


def test_the_worst_quarter_goes_on_from_the_best_quarter_and_the_others_as_they_are():
    before = ended([0.3, 0.9, 0.1, 0.5, 0.8, 0.4, 0.2, 0.6])
    found = [population().next_member(8 + k, before) for k in range(8)]
    assert [x.parent for x in found if x.parent not in (1, 4)] == [0, 3, 5, 7]
    for k in (0, 1, 3, 4, 5, 7):
        assert found[k].parent == k and found[k].labels == before[k].labels
    for k in (2, 6):
        model = before[found[k].parent].labels["rate"]
        assert found[k].labels["rate"] in (model * 0.8, model * 1.2)
    parents = {population().next_member(number, before).parent for number in range(2 + 8, 400, 8)}
    assert parents == {1, 4}, "any of the best"


def test_it_depends_on_the_number_and_the_seed_alone():
    before = ended([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0])
    assert population().next_member(8, before) == population().next_member(8, list(before))
    first = [population().next_member(k, []) for k in range(8)]
    assert all(x.parent is None and 1e-4 <= x.labels["rate"] <= 1e-2 for x in first)
    assert len({x.labels["rate"] for x in (*first, population(seed=6).next_member(0, []))}) == 9


def test_less_is_better_where_the_objective_says_so():
    less = Population(PopulationPlan(4, 2), RATE, False, 0)
    before = ended([4.0, 1.0, 2.0, 3.0])
    assert [less.next_member(4 + k, before).parent for k in range(4)] == [1, 1, 2, 3]
    assert [x.number for x in less.ranked(before)] == [1, 2, 3, 0]


def test_a_copy_of_an_equal_one_is_of_no_use():
    before = ended([0.0] * 8)
    assert [population().next_member(8 + k, before).parent for k in range(8)] == list(range(8))


def test_a_failed_member_is_replaced_however_many_failed():
    before = ended([None, None, None, 0.5, None, None, 0.4, None])
    found = [population().next_member(8 + k, before).parent for k in range(8)]
    assert all(parent in (3, 6) for parent in found) and found[3] == 3 and found[6] == 6
    with pytest.raises(ExtinctError, match="every training of generation 1 failed"):
        population().next_member(16, ended([None] * 8, first=8))


def test_a_perturbed_value_stays_in_its_range():
    """At an end only one factor leads inside; where none does, the value is the end."""
    field = population({"x": ValueRange(1.0, 10.0)})
    labels = [{"x": 1.0}] * 8
    assert field.next_member(8, ended([0.0, 9.0] + [5.0] * 6, labels)).labels == {"x": 1.2}
    narrow = population({"x": ValueRange(1.0, 1.1)})
    before = ended([0.0, 9.0] + [5.0] * 6, labels)
    assert {narrow.next_member(8 * k, before).labels["x"] for k in range(1, 20)} == {1.0, 1.1}


def test_whole_numbers_move_and_listed_values_go_to_a_neighbour():
    fields = {"epochs": ValueRange(1, 8), "parts": ListedValues((1, 2, 4, 8))}
    labels = [{"epochs": 2, "parts": 4}] * 8
    found = [population(fields).next_member(8 * k, ended([0.0, 9.0] + [5.0] * 6, labels)).labels for k in range(1, 40)]
    assert {x["epochs"] for x in found} == {1, 3} and {x["parts"] for x in found} == {2, 8}


def test_a_resampled_value_may_be_any():
    anew = population(resample=1.0)
    found = [anew.next_member(8 * k, ended([0.0, 9.0] + [5.0] * 6)).labels["rate"] for k in range(1, 60)]
    assert min(found) < 2e-4 and max(found) > 5e-3 and len(set(found)) == 59


def test_any_value_of_a_list_is_drawn():
    chance = random.Random(0)
    assert {drawn(ListedValues((1, [2, 3])), chance) for _ in range(40)} == {1, "[2, 3]"}


def test_whole_numbers_are_drawn_evenly():
    chance = random.Random(0)
    found = [drawn(ValueRange(1, 3), chance) for _ in range(300)]
    assert all(80 <= found.count(n) <= 120 for n in (1, 2, 3))
    assert {drawn(ValueRange(1, 4, log=True), chance) for _ in range(60)} == {1, 2, 3, 4}


def test_a_generation_ends_at_its_share_of_the_updates():
    plan = PopulationPlan(4, 5)
    assert [plan.end(number, 100) for number in (0, 3, 4, 19)] == [20, 20, 40, 100]
    assert (plan.count, plan.replaced, PopulationPlan(3, 2).replaced, PopulationPlan(9, 2).replaced) == (20, 1, 1, 2)
