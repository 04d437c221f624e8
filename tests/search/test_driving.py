"""Searches of a driver that sees nobody: what is found, kept, judged and explained."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from compiling import counted_programs
from jaxwalk.evaluation import evaluate, find_hits
from jaxwalk.evaluation.playing import play
from jaxwalk.metrics import OUTCOMES
from jaxwalk.scenarios import Archived
from jaxwalk.scenarios.archive_file import ArchiveError
from jaxwalk.scenarios.archived import keys_of, scenarios_at
from jaxwalk.search.cube import Candidates, ordinary
from jaxwalk.search.driving import Driving
from jaxwalk.search.grid import in_words
from jaxwalk.search.hunt import begun, keep_hunt, kept_hunt, method_of, play_generation
from jaxwalk.search.judging import judge
from jaxwalk.search.minimising import minimise
from jaxwalk.sim.scenario import FAR_AWAY
from jaxwalk.testing import check_source

PLAN = {"driver": "route-follower", "seed": 3}


@pytest.fixture(scope="module")
def tried(game):
    """Ordinary candidates, and what happened to them."""
    candidates = Candidates(ordinary(np.random.default_rng(0), 40, game.dimensions), np.arange(40))
    return candidates, game.play(candidates)


def test_critical_moments_agree_with_an_evaluation(game, tried):
    candidates, played = tried
    source = Archived(game.street, candidates.points, np.ones((40, 12), bool), game.seed, candidates.keys)
    check_source(source)
    rows = evaluate(game.street, game.policies, source, batch=16)
    outcomes, moments = rows[OUTCOMES], played.moments
    assert 5 < moments.failed.sum() < 40
    np.testing.assert_array_equal(moments.failed, outcomes.moving)
    mine = moments.failed
    np.testing.assert_array_equal(moments.ped[mine], outcomes.contact_ped[mine])
    np.testing.assert_array_equal(moments.frame[mine], outcomes.steps[mine])
    np.testing.assert_allclose(moments.speed[mine], outcomes.impact_speed[mine])
    hits = find_hits(rows)
    np.testing.assert_array_equal(moments.contact[hits.scenario[hits.moving]], hits.contact[hits.moving])
    assert (moments.score[mine] == 0).all() and (moments.score[~mine] < 0).all()
    assert (np.abs(moments.bearing[mine]) <= np.pi).all() and (moments.time[mine] >= 0).all()
    assert {in_words(cell).contact for cell in moments.cell[mine].tolist()} <= {"crosswalk", "jaywalk", "sidewalk"}
    assert not np.isnan(played.percentiles[mine]).any() and np.isnan(played.percentiles[~mine]).all()


def test_a_batch_does_not_change_an_episode(game, tried):
    candidates, played = tried
    again = game.play(candidates.some(slice(5, 8)))
    np.testing.assert_array_equal(again.moments.gap, played.moments.gap[5:8])


def test_who_is_absent_is_nowhere(game, tried):
    candidates, _ = tried
    absent = np.zeros((12, 16), bool)
    absent[3:] = True
    scenarios = scenarios_at(game.street, candidates.points[:16], absent)
    trajectory = play(game.street, game.policies, scenarios, keys_of(game.seed, candidates.keys[:16]))
    assert (trajectory.ped_x[:, :, 3:] == FAR_AWAY).all() and (trajectory.ped_vx[:, :, 3:] == 0).all()
    assert not trajectory.on_roadway[:, :, 3:].any() and not trajectory.touched[:, 3:].any()
    assert (trajectory.ped_x[:, :, :3] != FAR_AWAY).all()


@pytest.mark.parametrize("name", ["random", "map-elites", "cross-entropy", "evolution"])
def test_a_search_goes_on_where_it_stopped(game, name, tmp_path):
    """Three generations in one go, or kept and read after each, find the same."""
    method = method_of(name, game)
    whole, parted = begun(game, method), begun(game, method)
    for _ in range(3):
        play_generation(game, method, whole, 5)
        play_generation(game, method, parted, 5)
        keep_hunt(tmp_path / "state.safetensors", parted, PLAN)
        parted = kept_hunt(tmp_path / "state.safetensors", begun(game, method), PLAN)
    assert whole.log == parted.log and whole.simulations == 48
    np.testing.assert_array_equal(whole.elites.candidates.points, parted.elites.candidates.points)
    np.testing.assert_array_equal(whole.elites.quality, parted.elites.quality)
    assert whole.elites.best_failures.sum() == whole.log[-1].cells > 1
    assert (np.diff(whole.elites.cells[whole.elites.best_failures]) > 0).all()
    for name, array in whole.learned.items():
        np.testing.assert_array_equal(array, parted.learned[name])
    with pytest.raises(ArchiveError, match="was begun with another value of seed"):
        kept_hunt(tmp_path / "state.safetensors", begun(game, method), {**PLAN, "seed": 4})


def test_the_third_generation_of_an_evolution_compiles_nothing(game):
    """evosax compiles the steps of each strategy anew, so there may be only one."""
    method = method_of("evolution", game)
    hunt = begun(game, method)
    for _ in range(2):
        play_generation(game, method, hunt, 5)
    with counted_programs() as programs:
        play_generation(game, method, hunt, 5)
    assert programs == []


@pytest.mark.parametrize(
    "reached, message",
    [(-1, "cells reached fewer than 0 times"), (0, "cells of its scenarios that were never reached")],
)
def test_a_search_with_impossible_visits_is_refused(game, reached, message, tmp_path):
    """Such numbers would be chances below 0 of choosing a parent."""
    method, path = method_of("map-elites", game), tmp_path / "state.safetensors"
    hunt = begun(game, method)
    play_generation(game, method, hunt, 5)
    visits = hunt.elites.visits.copy()
    visits[hunt.elites.cells[0]] = reached
    hunt.elites = replace(hunt.elites, visits=visits)
    keep_hunt(path, hunt, PLAN)
    with pytest.raises(ArchiveError, match=f"state.safetensors: has {message}; search anew in another folder"):
        kept_hunt(path, begun(game, method), PLAN)


@pytest.mark.long
def test_failures_are_judged_and_explained(game, tried):
    """Somebody who looks would have avoided most; one person is enough for a contact with a blind car."""
    candidates, played = tried
    some = np.flatnonzero(played.moments.failed)[:6]
    failures, moments = candidates.some(some), played.moments.some(some)
    verdict = judge(game, failures, moments, batch=16)
    assert set(verdict.when_seen) | set(verdict.from_start) <= {"human", "oracle", "unavoidable"}
    assert (verdict.from_start != "unavoidable").sum() >= 4
    minimal = minimise(game, failures, moments.ped, lambda _: None)
    assert (minimal.present.sum(axis=1) == 1).all() and minimal.present[np.arange(6), moments.ped].all()
    assert minimal.played.moments.failed.all()
    np.testing.assert_array_equal(minimal.played.moments.ped, moments.ped)
    assert (minimal.changed >= 0).all() and (minimal.played.percentiles >= played.percentiles[some]).mean() > 0.5


def test_a_driver_is_searched_one_batch_after_the_other_or_two_at_once(game, tried):
    candidates, played = tried
    fresh = Driving(game.street, game.policies, game.seed, batch=16)
    np.testing.assert_array_equal(fresh.score(candidates), played.moments.score)
