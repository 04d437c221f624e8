"""What shields do and what they change, on episodes counted by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.evaluation.shield_effects import shield_effect, shield_effects
from jaxwalk.metrics import OUTCOMES, SHIELD_INTERVENTIONS, Rows, Summary, measure, summarise
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.metrics.expected_injuries import expected_injuries
from jaxwalk.metrics.footprint import FRONT, SIDE
from jaxwalk.sim.crossing_kind import JAYWALK
from metrics.scenes import Scene, Walk, trajectory

STEPS = 9
"""Steps of a recorded episode."""


@pytest.fixture(scope="module")
def bare():
    crossing = Walk(12, 0, crossings=[(5, 8, JAYWALK)])
    return trajectory(Scene(STEPS, [crossing], speed=4.0), Scene(STEPS, [Walk(90, 50)], speed=5.0))


def behind(bare, changed, infeasible):
    columns = (np.zeros((len(bare.car_x), 2), bool) for _ in range(2))
    acts, stuck = columns
    for episode, steps in enumerate(changed):
        acts[steps, episode] = True
    for episode, steps in enumerate(infeasible):
        stuck[steps, episode] = True
    return replace(bare, shield_changed=acts, shield_infeasible=stuck)


def test_interventions_are_unbroken_rows_of_changed_steps(bare):
    """Two in the first episode (steps 1 to 2, and 5), one in the second, and what follows an episode's end is none."""
    recorded = behind(bare, [[1, 2, 5], [3, 4]], [[], [4]])
    recorded = replace(recorded, length=np.array([8, 3]))
    rows = measure(recorded)
    found = rows[SHIELD_INTERVENTIONS]
    assert found.interventions.tolist() == [2, 1]
    assert found.changed.tolist() == [3, 1]
    assert found.infeasible.tolist() == [0, 0]
    numbers = summarise(rows, resamples=20)[SHIELD_INTERVENTIONS]
    km = rows[OUTCOMES].driven.sum() / 1000
    assert numbers.per_km.value == pytest.approx(3 / km)
    assert numbers.per_encounter.value == 3  # of one encounter
    assert (numbers.changed.value, numbers.changed.count) == (4 / 11, 11)
    assert numbers.infeasible.value == 0


def test_infeasible_steps_are_a_share_of_all(bare):
    numbers = summarise(measure(behind(bare, [[2], []], [[2], [7, 8]])), resamples=20)[SHIELD_INTERVENTIONS]
    assert numbers.infeasible.value == pytest.approx(3 / (2 * STEPS))


@pytest.mark.parametrize("known", ["shield_changed", "shield_infeasible"])
def test_half_a_record_of_a_shield_is_none(bare, known):
    half = replace(bare, **{known: np.ones(bare.car_x.shape, bool)})
    assert measure(half)[SHIELD_INTERVENTIONS].shielded.tolist() == [False, False]


def test_without_a_shield_there_are_no_numbers(bare):
    found = summarise(measure(bare), resamples=20)
    assert all((x.value, x.count) == (None, 0) for x in vars(found[SHIELD_INTERVENTIONS]).values())
    assert Summary.from_dict(json.loads(json.dumps(found.as_dict()))) == found


def _rows(contacts, *, steps, goal, driven) -> Rows:
    """Rows of two episodes, in those of ``contacts`` the moving car touches somebody: who walks stands in its way."""
    scenes = [Scene(STEPS, [Walk(6.0 if touched else 90.0, 0)], speed=8.0) for touched in contacts]
    rows = measure(trajectory(*scenes))
    table = replace(rows[OUTCOMES], steps=np.array(steps), goal=np.array(goal), driven=np.array(driven, np.float32))
    return rows.having(OUTCOMES, table)


def test_contacts_are_avoided_and_caused_in_pairs_of_scenarios():
    bare = _rows([True, False, True], steps=[80, 100, 90], goal=[True, True, False], driven=[60, 60, 30])
    after = _rows([False, True, True], steps=[95, 110, 90], goal=[True, True, True], driven=[60, 48, 60])
    found = shield_effect(("mine", "rss", "always-go"), 0.25, bare, after, "footprint")
    assert (found.both, found.avoided, found.caused, found.scenarios) == (1, 1, 1, 3)
    assert found.p == 1
    assert found.time_added.value == pytest.approx((1.5 + 1.0) / 2)
    assert found.time_added.count == 2
    assert found.metres_lost.value == pytest.approx((0 + 12 - 30) / 3)
    assert found.in_words.startswith("mine+rss among always-go: 1 contact of the moving car avoided and 1 caused in 3 ")


def _at(rows: Rows, speed: float, part: int) -> Rows:
    """The same rows, but every contact is at this speed of the car [m/s] and with this part of it."""
    table = rows[MEASURED_CONTACTS]
    speeds, parts = np.full(len(table.rule), speed, np.float32), np.full(len(table.rule), part, np.int8)
    return rows.having(MEASURED_CONTACTS, replace(table, car_speed=speeds, part=parts))


def test_more_contacts_may_be_less_harm():
    """One of four cars hits somebody with its front at 12 m/s; shielded, three are run into at their sides at 1.5 m/s.

    The risk is 1 / (1 + exp(0.460 - 0.091 f - 0.039 h - 0.002 f h)): f = 3.6 x 12 - 42.79 = 0.41 and
    h = 75 - 85.25 = -10.25 make 0.3035, and f = 5.4 - 42.79 = -37.39 makes 0.0294.
    """
    arrives = {"steps": [100] * 4, "goal": [True] * 4, "driven": [60] * 4}
    bare = _at(_rows([True, False, False, False], **arrives), 12.0, FRONT)
    after = _at(_rows([False, True, True, True], **arrives), 1.5, SIDE)
    found = shield_effect(("mine", "predictive", "always-go"), 0.25, bare, after, "footprint")
    assert (found.avoided, found.caused) == (1, 3)
    assert (found.bare.contacts, found.bare.front, found.bare.car_speed.value) == (1, 1, 12)
    assert (found.shielded.contacts, found.shielded.front, found.shielded.car_speed.value) == (3, 0, 1.5)
    assert found.bare.injuries == pytest.approx(303.5 / 4, abs=0.1)
    assert found.shielded.injuries == pytest.approx(3 * 29.4 / 4, abs=0.1)
    assert (found.bare.front_injuries, found.shielded.front_injuries) == (found.bare.injuries, 0)
    assert found.front_injuries_added.value == pytest.approx(-found.bare.injuries)
    assert found.injuries_added.value == pytest.approx(found.shielded.injuries - found.bare.injuries)
    assert "; bare 1 of 1 with its front, shielded 0 of 3; serious injuries" in found.in_words
    assert "1,000 scenarios: 75.9 bare, 22.1 shielded (-53.8 [" in found.in_words


def test_a_car_that_stands_injures_nobody():
    rows = _rows([True, False], steps=[80, 100], goal=[False, True], driven=[60, 60])
    table = rows[MEASURED_CONTACTS]
    standing = rows.having(MEASURED_CONTACTS, replace(table, moving=np.zeros(len(table.moving), bool)))
    first, second = expected_injuries(rows, "footprint")
    assert first > 0
    assert second == 0
    assert not expected_injuries(standing, "footprint").any()


def test_risks_of_several_people_in_an_episode_add_up():
    people = [Walk(6.0, 0), Walk(6.5, 0)]
    rows = _at(measure(trajectory(Scene(STEPS, people, speed=8.0))), 12.0, FRONT)
    assert expected_injuries(rows, "footprint") == pytest.approx([2 * 0.3035], abs=1e-3)


def test_only_drivers_that_were_evaluated_bare_too_are_compared():
    rows = _rows([False], steps=[8], goal=[False], driven=[6])
    played = {("a", "x"): rows, ("a+rss", "x"): rows, ("b+cbf", "x"): rows, ("a+cbf", "y"): rows}
    (found,) = shield_effects(played, 0.25, "footprint")
    assert (found.driver, found.shield, found.pedestrians) == ("a", "rss", "x")
