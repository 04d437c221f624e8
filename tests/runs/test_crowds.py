"""Updates that take turns with several numbers of people, on several streets."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from conftest import SMALL
from jaxwalk.recipes import RECIPES, with_training
from jaxwalk.runs.folder import Run
from jaxwalk.runs.progress import Display
from jaxwalk.runs.session import Session
from jaxwalk.runs.street import WorldError, make_street, on_devices
from jaxwalk.runs.training import begin, train_in

CROWDS = (2, 3)


@pytest.fixture(scope="module")
def small_town():
    """Recipe town, very small, on two streets with two or three people."""
    town = RECIPES["town"]
    roles = {
        name: replace(role, actor_hidden=(8,), critic_hidden=(8,), epochs=1) for name, role in town.train.roles.items()
    }
    return replace(with_training(town, **SMALL, roles=roles), maps=("training:2",), crowds=CROWDS)


def test_a_crowd_must_be_possible_and_critics_must_not_count_people(small_town):
    with pytest.raises(ValueError, match="pedestrians must be above 0, not 0"):
        replace(small_town, crowds=(12, 0))
    fast = replace(RECIPES["fast"], crowds=CROWDS)
    with pytest.raises(WorldError, match=r"crowds: train\.roles\.driver\.critic_observes must not have 'global'"):
        make_street(fast)
    with pytest.raises(WorldError, match=r"crowds.*credit"):
        make_street(replace(RECIPES["paper"], crowds=CROWDS))


def test_the_tables_of_streets_are_once_on_every_device(small_town):
    experiment = with_training(small_town, shards=2)
    few, many = (jax.tree.leaves(street.world.tables) for street in on_devices(make_street(experiment), experiment))
    assert all(one is other for one, other in zip(few, many, strict=True))
    assert {len(table.sharding.device_set) for table in few} == {2}


@pytest.mark.long
def test_a_resumed_training_of_crowds_equals_an_uninterrupted_one(small_town, tmp_path, quiet, monkeypatch):
    whole = Run.create(tmp_path / "whole", small_town)
    train_in(whole, display=Display(quiet))
    assert [line["people"] for line in whole.metrics()] == [2, 3, 2, 3, 2, 3]

    record = Session.record

    def record_and_stop(self, metrics, updates, before):
        record(self, metrics, updates, before)
        self.stop.requested |= updates == 2

    monkeypatch.setattr(Session, "record", record_and_stop)
    cut = Run.create(tmp_path / "cut", small_town)
    assert train_in(cut, display=Display(quiet)).interrupted
    monkeypatch.undo()
    assert not train_in(Run.open(cut.path), resume=True, display=Display(quiet)).interrupted
    assert cut.policy.read_bytes() == whole.policy.read_bytes()
    told = [[{**line, "seconds": 0} for line in run.metrics()] for run in (whole, cut)]
    assert told[0] == told[1]

    learner = begin(whole, make_street(small_town, whole.maps()), resume=True)
    streams = (learner.stream, *learner.parked)
    assert [x.state.pedestrian.x.shape for x in streams] == [(people, 8) for people in CROWDS]
    assert {int(x) for stream in streams for x in np.asarray(stream.scenario.map)} == {0, 1}
