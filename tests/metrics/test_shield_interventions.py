"""What shields do and what they change, on episodes counted by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.evaluation.shield_effects import shield_effect, shield_effects
from jaxwalk.metrics import OUTCOMES, SHIELD_INTERVENTIONS, Rows, Summary, measure, summarise
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


def test_without_a_shield_there_are_no_numbers(bare):
    found = summarise(measure(bare), resamples=20)
    assert all(number.value is None for number in vars(found[SHIELD_INTERVENTIONS]).values())
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


def test_only_drivers_that_were_evaluated_bare_too_are_compared():
    rows = _rows([False], steps=[8], goal=[False], driven=[6])
    played = {("a", "x"): rows, ("a+rss", "x"): rows, ("b+cbf", "x"): rows, ("a+cbf", "y"): rows}
    (found,) = shield_effects(played, 0.25, "footprint")
    assert (found.driver, found.shield, found.pedestrians) == ("a", "rss", "x")
