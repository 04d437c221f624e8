"""A plan is shortened while a machine is too slow for it, and lengthened again when the machine is free."""

from __future__ import annotations

from itertools import count, pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxwalk.runs import planning
from jaxwalk.runs.planning import UpdatePlan

LIMIT, UPDATES = 180.0, 270
EACH = LIMIT / UPDATES


def train(slowness, *, updates=UPDATES, cycle=1, limit=LIMIT, ahead=False):
    """When updates end [s], and the plans then; updates take ``slowness(time, made)`` times as long as planned.

    ``ahead``: it is asked for before each update and answers after it, as of several processes.
    """
    clock, ends, plans = 0.0, [], []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planning.time, "monotonic", lambda: clock)
        plan = UpdatePlan(0, updates, cycle)
        for made in count(1):
            planned = plan.follow(made - 1, limit - clock) if ahead else None
            clock += limit / updates * slowness(clock, made - 1) if limit < float("inf") else 1.0 + clock
            planned = planned if ahead else plan.follow(made, limit - clock)
            ends.append(clock)
            plans.append(planned)
            if made >= planned:
                return ends, plans


def changes(plans, updates=UPDATES):
    return [after - before for before, after in pairwise([updates, *plans]) if after != before]


@pytest.mark.parametrize("slowness", [1.0, 0.9])
def test_a_plan_that_fits_stays(slowness):
    ends, plans = train(lambda *_: slowness)
    assert len(ends) == UPDATES
    assert not changes(plans)


def test_one_slow_update_changes_nothing():
    _, plans = train(lambda _, made: 2.0 if made == 100 else 1.0)
    assert not changes(plans)


@pytest.mark.parametrize("updates", [4, 7, 9, 10, 23, 30, 50, 149])
def test_updates_of_a_cycle_may_take_different_times(updates):
    """As with 12, 3, 72 and 36 people in turn; the limit is what whole cycles allow."""
    each = [number + 5 for number in (12, 3, 72, 36)]
    _, plans = train(lambda _, made: each[made % 4] / (sum(each) / 4), updates=updates, cycle=4)
    assert not changes(plans, updates)


@pytest.mark.parametrize("ahead", [False, True])
def test_on_a_machine_that_became_slower_it_is_shortened_once_and_ends_in_time(ahead):
    ends, plans = train(lambda *_: 2.0, ahead=ahead)
    assert changes(plans) == [pytest.approx(-UPDATES / 2, abs=2)]
    assert ends[-1] == pytest.approx(LIMIT, abs=2 * EACH)


@pytest.mark.parametrize("begun", [0.0, 40.0, 60.0])
@pytest.mark.parametrize("ahead", [False, True])
def test_a_minute_of_other_work_costs_the_updates_of_that_minute_alone(begun, ahead):
    ends, plans = train(lambda now, _: 2.0 if begun <= now < begun + 60 else 1.0, ahead=ahead)
    possible = UPDATES - 60 / EACH / 2
    assert 0.9 * possible < len(ends) <= possible + 1
    assert min(plans) < 0.9 * possible  # it was shortened in that minute
    assert max(changes(plans)) > 0
    assert len(changes(plans)) < 10
    assert ends[-1] < LIMIT + 2 * EACH


def test_a_plan_that_is_nearly_done_is_lengthened_at_once():
    ends, plans = train(lambda now, _: 10.0 if 150 <= now < 170 else 1.0)
    assert changes(plans)[-1] > 0
    assert LIMIT - 3 * EACH < ends[-1] < LIMIT + 2 * EACH


def test_without_a_limit_nothing_changes():
    _, plans = train(None, limit=float("inf"))
    assert not changes(plans)


def test_one_update_more_is_the_shortest_plan():
    plan = UpdatePlan(0, 10)
    assert [plan.follow(made, left) for made, left in ((1, 9.0), (2, -5.0), (3, -5.0))] == [10, 3, 3]


@given(st.lists(st.floats(0.3, 8.0), min_size=1, max_size=20), st.booleans())
def test_whatever_the_pace_no_plan_is_longer_than_the_first_or_over_before_it_is_made(paces, ahead):
    ends, plans = train(lambda now, _: paces[int(now / LIMIT * len(paces)) % len(paces)], ahead=ahead)
    assert len(ends) == plans[-1]
    assert all(made < planned <= UPDATES for made, planned in enumerate(plans[:-1], start=1))
