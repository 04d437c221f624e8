"""The matched and the placebo speed differential on scenes whose numbers are worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.metrics import PLACEBO, SPEED_DIFFERENTIAL, measure, summarise
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.sim_config import SimConfig
from metrics.scenes import Scene, Walk, changed, ghosts_of, trajectory, turned


def meeting(kind: int, speed: float, *, initial: float = 6.0, place: float = 0.0) -> Scene:
    """A car closes in on somebody 8 m ahead of it for two frames, with ``initial`` and then ``speed``."""
    return Scene(2, [Walk(place + 8, 0, crossings=[(1, 2, kind)])], x=place, speed=[initial, initial, speed])


def near_six(*scenes: Scene):
    return summarise(measure(trajectory(*scenes)), resamples=50)[SPEED_DIFFERENTIAL][2]


def test_matched_differences_are_averaged_over_places():
    """At one place, 2 jaywalkers' and 1 crosswalk user's: 5 against 4, weight 2 * 1 / 3. At another, 1 and 1: 6
    against 3, weight 1 / 2. A third place has no crosswalk user. The bin's mean is over both frames there."""
    here = [meeting(JAYWALK, 3), meeting(JAYWALK, 5), meeting(CROSSWALK, 2)]
    there = [meeting(JAYWALK, 6, place=40), meeting(CROSSWALK, 0, place=40)]
    alone = [meeting(JAYWALK, 0, place=80)]
    found = near_six(*here, *there, *alone).matched
    # means over the frames with 6 m/s and with the later speed: 4.5 and 5.5 against 4; 6 against 3
    assert found.value == pytest.approx((2 / 3 * (5 - 4) + 1 / 2 * (6 - 3)) / (2 / 3 + 1 / 2))
    assert found.count == 3


def test_strata_that_are_resampled_one_after_the_other_have_the_same_numbers(monkeypatch):
    here = [meeting(JAYWALK, 3), meeting(JAYWALK, 5), meeting(CROSSWALK, 2)]
    there = [meeting(JAYWALK, 6, place=40), meeting(CROSSWALK, 0, place=40), meeting(CROSSWALK, 1, place=40)]
    together = near_six(*here, *there).matched
    monkeypatch.setattr("jaxwalk.metrics.meetings.AT_ONCE", 1)
    found = near_six(*here, *there).matched
    assert found.count == together.count == 3
    assert (found.value, found.low, found.high) == pytest.approx((together.value, together.low, together.high))


def test_only_cars_as_fast_at_first_are_matched():
    assert near_six(meeting(JAYWALK, 3), meeting(CROSSWALK, 3, initial=4.0)).matched.count == 0
    assert near_six(meeting(JAYWALK, 3), meeting(CROSSWALK, 3, initial=6.4)).matched.count == 1


@pytest.mark.parametrize("quarters", [0, 1])
def test_only_places_of_5_m_around_are_matched(quarters):
    def matched(place):  # of the jaywalker's car; the other is at 0
        recorded = turned(trajectory(meeting(JAYWALK, 3, place=place), meeting(CROSSWALK, 3)), quarters)
        return summarise(measure(recorded), resamples=5)[SPEED_DIFFERENTIAL][2].matched.count

    assert [matched(place) for place in (1.2, 2.8, 5.5)] == [1, 0, 0]


def test_place_and_speed_must_both_be_alike():
    """The jaywalker's car is at another place than one car, and not within the same m/s as the other."""
    others = meeting(CROSSWALK, 3, initial=6.4, place=40), meeting(CROSSWALK, 3, initial=7.0)
    assert near_six(meeting(JAYWALK, 3, initial=6.4), *others).matched.count == 0


def test_a_car_that_heads_halfway_between_two_quarters_is_matched_along_x():
    recorded = trajectory(meeting(JAYWALK, 3), meeting(CROSSWALK, 3))
    halfway = np.where(np.arange(2) == 1, 0.5**0.5, 1.0)
    both = recorded.car_cos * halfway
    other = changed(recorded, car_cos=both, car_sin=np.where(halfway < 1, both, 0.0))
    assert summarise(measure(other), resamples=5)[SPEED_DIFFERENTIAL][2].matched.count == 1


def test_resamples_without_a_match_at_one_place_use_the_others():
    """Three of each at two places, always 5 against 4 m/s: whatever is drawn, the difference is 1."""
    scenes = [meeting(kind, speed, place=place) for kind, speed in ((JAYWALK, 4), (CROSSWALK, 2)) for place in (0, 40)]
    found = near_six(*3 * scenes).matched
    assert (found.value, found.low, found.high) == pytest.approx((1, 1, 1))


def test_cars_with_another_heading_are_not_matched():
    recorded = trajectory(meeting(JAYWALK, 3), meeting(CROSSWALK, 3))
    back = np.where(np.arange(2) == 1, -1.0, 1.0)
    # the second car drives backwards in space, so that it still closes in: only its heading differs
    other = changed(recorded, car_cos=recorded.car_cos * back, car_speed=recorded.car_speed * back)
    assert summarise(measure(other), resamples=5)[SPEED_DIFFERENTIAL][2].matched.count == 0


def test_without_ghosts_there_is_no_placebo():
    placebo = near_six(meeting(JAYWALK, 3), meeting(CROSSWALK, 3)).placebo
    assert (placebo.people.jaywalk.count, placebo.ghosts.jaywalk.count) == (0, 0)
    assert (placebo.people.difference.value, placebo.difference.value) == (None, None)


def test_people_minus_ghosts():
    """The car does 6 and then 2 m/s near a jaywalker, 6 and 4 near a crosswalk user: -1. Near the ghosts, 0 and +1."""
    people = trajectory(meeting(JAYWALK, 2), meeting(CROSSWALK, 4))
    others = ghosts_of(trajectory(meeting(CROSSWALK, 2), meeting(JAYWALK, 4)))
    found = summarise(measure(people, others), resamples=5)[SPEED_DIFFERENTIAL][2].placebo
    assert found.people.difference.value == pytest.approx(4 - 5)
    assert found.ghosts.difference.value == pytest.approx(5 - 4)
    assert found.difference.value == pytest.approx(-2)


def test_the_first_touch_of_either_ends_the_view_of_both():
    """The car drives at 5 m/s past a person 2 m beside its way; 1 m ahead of the start stands a ghost, or 4 m."""
    person = Walk(2, 2, crossings=[(0, 9, JAYWALK)])
    recorded = trajectory(Scene(9, [person]))
    for place, frames in ((1.0, 1), (4.0, 7), (40.0, 10)):  # 2.5 of 4 m are driven, and a bit more, in frame 6
        ghost = ghosts_of(trajectory(Scene(9, [Walk(place, 0, crossings=[(0, 9, JAYWALK)])])))
        rows = measure(recorded, ghost)
        assert rows[PLACEBO].frames.sum() == min(frames, 10), place
        assert rows[SPEED_DIFFERENTIAL].frames.sum() == 10


def test_a_ghost_is_touched_by_the_rule_of_the_world():
    """4 m ahead of a car that is 2.25 m to its front, a body of 0.25 m is touched after 2 m: in frame 4."""
    recorded = trajectory(Scene(9, [Walk(2, 2, crossings=[(0, 9, JAYWALK)])]))
    ghost = ghosts_of(trajectory(Scene(9, [Walk(4, 0, crossings=[(0, 9, JAYWALK)])])))
    rows = measure(recorded, ghost, config=SimConfig(contact="footprint"))
    assert rows[PLACEBO].frames.sum() == 5
