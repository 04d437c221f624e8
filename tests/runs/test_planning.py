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


def train(slowness, limit=LIMIT):
    """Times [s] at which updates end, and the plans then; updates take ``slowness(time)`` times as long as planned."""
    clock, ends, plans = 0.0, [], []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planning.time, "monotonic", lambda: clock)
        plan = UpdatePlan(0, UPDATES)
        for made in count(1):
            clock += EACH * slowness(clock)
            ends.append(clock)
            plans.append(plan.follow(made, limit - clock))
            if made >= plan.updates:
                return ends, plans


def changes(plans):
    return [after - before for before, after in pairwise([UPDATES, *plans]) if after != before]


def test_a_plan_that_fits_stays():
    ends, plans = train(lambda _: 1.0)
    assert len(ends) == UPDATES
    assert not changes(plans)


def test_on_a_machine_that_became_slower_it_is_shortened_once_and_ends_in_time():
    ends, plans = train(lambda _: 2.0)
    assert changes(plans) == [pytest.approx(-UPDATES / 2, abs=1)]
    assert ends[-1] == pytest.approx(LIMIT, abs=2 * EACH)


@pytest.mark.parametrize("begun", [0.0, 60.0])
def test_a_minute_of_other_work_costs_the_updates_of_that_minute_alone(begun):
    ends, plans = train(lambda now: 2.0 if begun <= now < begun + 60 else 1.0)
    possible = UPDATES - 60 / EACH / 2
    assert 0.9 * possible < len(ends) <= possible + 1
    assert min(plans) < 0.9 * possible  # it was shortened in that minute
    assert max(changes(plans)) > 0
    assert ends[-1] < LIMIT + 2 * EACH


def test_without_a_limit_nothing_changes():
    _, plans = train(lambda now: 1.0 + now, limit=float("inf"))
    assert not changes(plans)


def test_one_update_is_the_shortest_plan():
    plan = UpdatePlan(10, 11)
    assert plan.follow(11, -5.0) == 11


@given(st.lists(st.floats(0.3, 8.0), min_size=1, max_size=20))
def test_whatever_the_pace_no_plan_is_longer_than_the_first_or_shorter_than_what_was_made(paces):
    ends, plans = train(lambda now: paces[int(now / LIMIT * len(paces)) % len(paces)])
    assert len(ends) == plans[-1]
    assert all(made <= planned <= UPDATES for made, planned in enumerate(plans, start=1))
