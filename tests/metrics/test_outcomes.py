"""Outcomes, contacts, attribution and decisions on scenes whose numbers are worked out by hand."""

from __future__ import annotations

import json

import numpy as np
import pytest

from jaxwalk.metrics import (
    ATTRIBUTION,
    ENCOUNTERS,
    JAYWALK_RATE,
    OUTCOMES,
    SPEED_DIFFERENTIAL,
    Rows,
    measure,
    summarise,
)
from jaxwalk.metrics.outcomes import NO_CONTACT, SIDEWALK
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.sim_config import SimConfig
from metrics.scenes import Scene, Walk, changed, pick, trajectory, turned

AWAY = Walk(90, 50)


@pytest.fixture(scope="module")
def recorded():
    """One goal after 4 s, one after 2 s, a timeout, and four collisions: see the comments."""
    return trajectory(
        Scene(40, [AWAY, AWAY], goal=True),  # 20 m
        Scene(20, [AWAY, Walk(50, 9, crossings=[(1, 10, CROSSWALK)])], goal=True),  # 10 m
        Scene(50, [AWAY, AWAY]),  # 25 m
        Scene(10, [AWAY, Walk(6, 0, crossings=[(2, 10, JAYWALK)])], touched=[1]),  # 5 m, at 5 m/s
        Scene(10, [AWAY, Walk(6, 0)], touched=[1], speed=3.0),  # 3 m, on the sidewalk, at 3 m/s
        Scene(10, [AWAY, Walk(2, 0, vx=-1, crossings=[(1, 10, CROSSWALK)])], touched=[1], speed=0.0),  # walked into
        Scene(10, [Walk(6, 0, crossings=[(1, 10, CROSSWALK)]), AWAY], touched=[0], speed=[4.0] * 10 + [2.0]),  # 3.8 m
    )


def test_rows_of_episodes(recorded):
    table = measure(recorded)[OUTCOMES]
    assert table.driven == pytest.approx([20, 10, 25, 5, 3, 0, 3.8])
    assert table.contact.tolist() == [NO_CONTACT] * 3 + [JAYWALK, SIDEWALK, CROSSWALK, CROSSWALK]
    assert table.contact_ped.tolist() == [-1, -1, -1, 1, 1, 1, 0]
    assert table.moving.tolist() == [False] * 3 + [True, True, False, True]
    assert table.impact_speed == pytest.approx([np.nan] * 3 + [5, 3, 0, 2], nan_ok=True)


def test_outcomes(recorded):
    outcomes = summarise(measure(recorded), resamples=200)[OUTCOMES]
    assert [r.successes for r in (outcomes.goal, outcomes.collision, outcomes.timeout)] == [2, 4, 1]
    assert outcomes.goal.value == pytest.approx(2 / 7)
    assert (outcomes.time_to_goal.value, outcomes.time_to_goal.count) == (pytest.approx(3.0), 2)
    assert outcomes.time_to_goal_error == pytest.approx(1.0)  # spread sqrt(2) over sqrt(2)
    assert outcomes.kilometres == pytest.approx(0.0668)
    assert outcomes.all.per_km.value == pytest.approx(4 / 0.0668)
    assert outcomes.moving.per_km.value == pytest.approx(3 / 0.0668)
    assert outcomes.standing.per_km.value == pytest.approx(1 / 0.0668)
    # encounters: the three on a roadway who were hit; 40 m away nobody is encountered
    assert outcomes.encounters == 3
    assert outcomes.all.per_encounter.value == pytest.approx(4 / 3)
    # 2.5 -+ 3.18 * 2.08 / 2, and no speed is below 0
    assert (outcomes.impact_speed.value, outcomes.impact_speed.low) == (pytest.approx(2.5), 0)


def test_contacts(recorded):
    outcomes = summarise(measure(recorded), resamples=0)[OUTCOMES]
    contacts = [outcomes.crosswalk, outcomes.jaywalk, outcomes.sidewalk]
    assert [(c.share.successes, c.share.trials, c.moving, c.standing) for c in contacts] == [
        (2, 4, 1, 1),
        (1, 4, 1, 0),
        (1, 4, 1, 0),
    ]
    assert [c.impact_speed.value for c in contacts] == pytest.approx([1.0, 5.0, 3.0])


def test_attribution(recorded):
    attribution = summarise(measure(recorded), resamples=0)[ATTRIBUTION]
    assert (attribution.share.value, attribution.share.count) == (pytest.approx(1 / 3), 3)
    # crossings: 3 crosswalk, 1 jaywalk; on the road 3 x 1.0 s and 0.9 s; all but the one 40 m away are near
    risks = attribution.per_crossing, attribution.per_encounter, attribution.per_second, attribution.per_second_near
    assert [(r.exposure_crosswalk, r.exposure_jaywalk) for r in risks] == [
        (3, 1),
        (2, 1),
        (pytest.approx(3.0), pytest.approx(0.9)),
        (pytest.approx(2.0), pytest.approx(0.9)),
    ]
    assert [(r.crosswalk.value, r.crosswalk.count, r.jaywalk.count) for r in risks] == [
        (pytest.approx(2 / r.exposure_crosswalk), 2, 1) for r in risks
    ]
    assert [r.ratio.value for r in risks] == pytest.approx([1.5, 1.0, (1 / 0.9) / (2 / 3), (1 / 0.9) / 1.0])
    assert (attribution.per_crossing.share.value, attribution.per_crossing.share.count) == (pytest.approx(0.25), 4)


@pytest.mark.parametrize(("place", "seconds"), [(20.0, 0.2), (20.1, 0.0)])
def test_a_car_20_m_away_is_near(place, seconds):
    recorded = trajectory(Scene(1, [Walk(place, 0, crossings=[(0, 1, CROSSWALK)])], speed=0.0))
    found = summarise(measure(recorded), resamples=0)[ATTRIBUTION]
    assert found.per_second.exposure_crosswalk == pytest.approx(0.2)
    assert found.per_second_near.exposure_crosswalk == pytest.approx(seconds)


@pytest.mark.parametrize("quarters", [0, 1])
def test_of_several_touched_the_nearest_counts(quarters):
    people = [Walk(3.8, 0, crossings=[(1, 10, CROSSWALK)]), Walk(6, 0)]  # the car is at 5
    rows = measure(turned(trajectory(Scene(10, people, touched=[0, 1])), quarters))
    assert (rows[OUTCOMES].contact.tolist(), rows[OUTCOMES].contact_ped.tolist()) == ([SIDEWALK], [1])
    assert rows[ENCOUNTERS].collided.tolist() == [True]


def test_a_collision_that_touched_nobody_is_named():
    recorded = trajectory(Scene(4, [AWAY]), Scene(4, [AWAY], touched=[0]))
    with pytest.raises(ValueError, match="episode 1 ends with a collision that touched nobody"):
        measure(changed(recorded, touched=np.zeros_like(recorded.touched)))


def test_moving_begins_at_the_given_speed():
    recorded = trajectory(Scene(4, [Walk(1, 0)], touched=[0], speed=0.5))
    assert measure(recorded)[OUTCOMES].moving.tolist() == [True]
    assert measure(recorded, config=SimConfig(moving_speed=0.6))[OUTCOMES].moving.tolist() == [False]


def test_decisions_by_quarter_of_tau():
    # who decides: tau 0.1 (no), 0.25 (jaywalks; second quarter), 0.9 (jaywalks, then not), 1.0 (jaywalks)
    people = [
        Walk(90, 50, tau=0.1, crossings=[(2, 4, CROSSWALK)]),
        Walk(90, 50, tau=0.25, crossings=[(2, 4, JAYWALK)]),
        Walk(90, 50, tau=0.9, crossings=[(2, 4, JAYWALK), (8, 9, CROSSWALK)]),
        Walk(90, 50, tau=1.0, crossings=[(0, 4, JAYWALK)]),
    ]
    rates = summarise(measure(trajectory(Scene(20, people))), resamples=0)[JAYWALK_RATE]
    assert [(r.successes, r.trials) for r in rates.quarters] == [(0, 1), (1, 1), (0, 0), (2, 3)]
    assert (rates.all.successes, rates.all.trials, rates.unknown) == (3, 5, 0)


def test_several_decisions_in_a_frame_are_one_row_and_the_lost_ones_are_counted():
    recorded = trajectory(Scene(9, [Walk(90, 50, crossings=[(3, 5, JAYWALK)])]))
    rows = measure(changed(recorded, decisions=recorded.decisions * 3))
    assert (rows[JAYWALK_RATE].made.tolist(), rows[JAYWALK_RATE].frame.tolist()) == ([3], [2])
    rates = summarise(rows, resamples=0)[JAYWALK_RATE]
    assert (rates.all.successes, rates.all.trials, rates.unknown) == (1, 1, 2)


def test_a_decision_after_the_end_is_not_seen():
    recorded = trajectory(Scene(5, [Walk(90, 50, crossings=[(7, 8, JAYWALK)])]), Scene(9, [AWAY]))
    assert len(measure(recorded)[JAYWALK_RATE].frame) == 0


@pytest.mark.parametrize("episodes", [0, 1])
def test_where_nothing_happens_numbers_are_none(episodes):
    recorded = pick(trajectory(Scene(9, [AWAY], speed=0.0)), episodes=slice(0, episodes))
    summary = summarise(measure(recorded), resamples=20)
    assert summary.episodes == episodes
    assert (summary[OUTCOMES].goal.value is None) == (episodes == 0)
    assert summary[OUTCOMES].all.per_km.value is None
    assert summary[OUTCOMES].time_to_goal.value is None
    assert summary[ATTRIBUTION].per_crossing.ratio.value is None
    assert summary[SPEED_DIFFERENTIAL][0].pooled.difference.value is None
    json.dumps(summary.as_dict(), allow_nan=False)


def test_the_summary_is_json(recorded):
    again = json.loads(json.dumps(summarise(measure(recorded), resamples=20).as_dict(), allow_nan=False))
    assert again["outcomes"]["goal"]["successes"] == 2


def test_refusals(recorded):
    with pytest.raises(ValueError, match="touched nobody"):
        measure(changed(recorded, touched=recorded.touched & False))
    with pytest.raises(ValueError, match="one frame more"):
        measure(changed(recorded, length=recorded.length + 1))
    with pytest.raises(ValueError, match="no rows"):
        Rows.join([])
    with pytest.raises(ValueError, match="step durations"):
        Rows.join([measure(recorded), measure(changed(recorded, dt=0.2))])
