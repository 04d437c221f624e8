from __future__ import annotations

import dataclasses

import jax
import numpy as np
import pytest

from evaluation.test_hosted import hosted
from jaxwalk import rollout
from jaxwalk.evaluation import episodes_at_once, evaluate, replay, with_jaywalk_multiplier
from jaxwalk.metrics import OUTCOMES
from jaxwalk.platforms import traced_for
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import SimConfig


def test_how_many_are_asked_for_changes_no_row(street, driver, undecided, rows):
    assert rows[OUTCOMES].scenario.tolist() == list(range(40))
    for count in (3, 17):
        fewer = evaluate(street, {"driver": driver, "pedestrian": undecided}, Drawn(street, 7, count), batch=16)
        for field in dataclasses.fields(rows[OUTCOMES]):
            a, b = getattr(fewer[OUTCOMES], field.name), getattr(rows[OUTCOMES], field.name)[:count]
            np.testing.assert_array_equal(a, b, err_msg=field.name)


def test_the_batch_size_changes_roundings_at_most(street, driver, undecided, rows):
    other = evaluate(street, {"driver": driver, "pedestrian": undecided}, Drawn(street, 7, 40), batch=25)
    for field in dataclasses.fields(rows[OUTCOMES]):
        a, b = getattr(other[OUTCOMES], field.name), getattr(rows[OUTCOMES], field.name)
        np.testing.assert_allclose(a, b, rtol=1e-5, err_msg=field.name)


@pytest.mark.parametrize(
    ("people", "episodes"), [(1, 512), (12, 512), (13, 256), (24, 256), (48, 128), (72, 64), (400, 64)]
)
def test_fewer_episodes_are_played_at_once_where_there_are_many_people(people, episodes, driver, monkeypatch):
    monkeypatch.setattr("jaxwalk.evaluation.batches.BATCH", 512)
    street = Street.create(config=SimConfig(pedestrians=people))
    assert episodes_at_once(street, {"driver": driver}) == episodes


def test_a_gpu_and_a_driver_that_is_asked_batch_by_batch_play_as_many_as_ever(driver, monkeypatch):
    monkeypatch.setattr("jaxwalk.evaluation.batches.BATCH", 512)
    street = Street.create(config=SimConfig(pedestrians=72))
    assert episodes_at_once(street, {"driver": hosted()}) == 512
    with traced_for("gpu"):
        assert episodes_at_once(street, {"driver": driver}) == 512


def test_an_evaluation_can_be_replayed(street, driver, undecided, rows):
    for scenario in (0, 18, 39):
        episode = replay(street, {"driver": driver, "pedestrian": undecided}, Drawn(street, 7), [scenario], batch=16)
        assert episode.scenario.tolist() == [scenario]
        assert episode.length[0] == rows[OUTCOMES].steps[scenario]
        assert episode.goal[0] == rows[OUTCOMES].goal[scenario]
        assert episode.car_x.shape == (episode.length[0] + 1, 1)
        assert episode.ped_x.shape == (episode.length[0] + 1, 1, 12)


def test_progress_is_told_after_every_batch(street, driver, undecided):
    told = []
    evaluate(
        street,
        {"driver": driver, "pedestrian": undecided},
        Drawn(street, 8, 20),
        batch=16,
        progress=lambda *n: told.append(n),
    )
    assert told == [(16, 20), (20, 20)]


@pytest.mark.parametrize(("wrong", "value"), [("count", 0), ("count", 2**30 + 1), ("seed", -1), ("seed", 2**31)])
def test_impossible_sets_are_refused(street, wrong, value):
    with pytest.raises(ValueError, match=wrong):
        Drawn(street, **({"seed": 1, "count": 4} | {wrong: value}))


def test_a_batch_has_an_episode_at_least(street, driver, undecided):
    policies = {"driver": driver, "pedestrian": undecided}
    with pytest.raises(ValueError, match="batch must be at least 1"):
        evaluate(street, policies, Drawn(street, 1, 4), batch=0)
    with pytest.raises(ValueError, match="batch must be at least 1"):
        replay(street, policies, Drawn(street, 1, 4), [0], batch=0)


def test_there_is_no_scenario_below_0(street, driver, undecided):
    with pytest.raises(ValueError, match="scenario must lie in"):
        replay(street, {"driver": driver, "pedestrian": undecided}, Drawn(street, 1), [-1])
    with pytest.raises(ValueError, match="replay takes 1 to 16 scenarios at once, not 17"):
        replay(street, {"driver": driver, "pedestrian": undecided}, Drawn(street, 1), range(17), batch=16)


def test_the_hash_stands_for_the_scenarios(street):
    digest = Drawn(street, 7, 20).hash()
    assert len(digest) == 16
    assert int(digest, 16) >= 0
    assert Drawn(street, 7, 20).hash() == digest
    assert Drawn(with_jaywalk_multiplier(street, 1.0), 7, 20).hash() == digest
    assert len({digest, *(Drawn(street, s, n).hash() for s, n in [(7, 21), (8, 20)])}) == 3


def test_scenarios_are_numbered_and_never_those_of_a_training(street):
    many, keys = Drawn(street, 7).take(np.arange(16))
    two, two_keys = Drawn(street, 7).take(5 + np.arange(2))
    jax.tree.map(lambda a, b: np.testing.assert_array_equal(a[..., 5:7], b), many, two)
    np.testing.assert_array_equal(jax.random.key_data(keys[5:7]), jax.random.key_data(two_keys))
    training = rollout.environment_keys(rollout.seed_key(7, rollout.TRAINING), 0, 16)
    trained = rollout.start(street, training).scenario
    drawn = np.concatenate([many.traits, trained.traits], axis=-1).reshape(-1, 32)
    assert len(np.unique(drawn, axis=1).T) == 32


def test_a_rollout_with_the_same_keys_begins_with_the_same_scenarios(street):
    scenarios, keys = Drawn(street, 7).take(np.arange(16))
    begun = rollout.start(street, keys).scenario
    jax.tree.map(np.testing.assert_array_equal, scenarios, begun)
