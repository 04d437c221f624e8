"""The host loop: the same result however it was interrupted, and nothing lost or told twice."""

import io
from contextlib import ExitStack
from dataclasses import replace
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from rich.console import Console

from jaxwalk.learning import checkpoint, mappo
from jaxwalk.learning.config import WHOLE_MINIBATCH, TrainConfig
from jaxwalk.policies import load_policy, read_metadata
from jaxwalk.recipes import single_agent, with_training
from jaxwalk.runs import street
from jaxwalk.runs.folder import Run
from jaxwalk.runs.planning import replan
from jaxwalk.runs.progress import Display
from jaxwalk.runs.session import DivergedError, Session
from jaxwalk.runs.street import make_street, shared_out, whole_minibatches
from jaxwalk.runs.training import UnwrittenError, begin, is_finished, train_in
from limits import files_at_most
from reliability.kill_training import board


@pytest.fixture
def stopping(monkeypatch):
    """Ctrl-C in the update after the one whose number is given."""

    def stop_after(number):
        record = Session.record

        def record_and_stop(self, metrics, updates, before):
            record(self, metrics, updates, before)
            self.stop.requested |= updates == number

        monkeypatch.setattr(Session, "record", record_and_stop)

    yield stop_after
    monkeypatch.undo()


def _learner(run):
    learner = begin(run, make_street(run.experiment), resume=True)
    return [
        jax.random.key_data(x) if jnp.issubdtype(x.dtype, jax.dtypes.prng_key) else x for x in jax.tree.leaves(learner)
    ]


def _assert_same(a, b):
    for x, y in zip(_learner(a), _learner(b), strict=True):
        np.testing.assert_array_equal(x, y)


def _told(run):
    """The metrics without times."""
    return [{name: x for name, x in line.items() if name != "seconds"} for line in run.metrics()]


def test_environments_are_shared_out_among_the_cores(tiny):
    def shards(environments):
        return shared_out(with_training(tiny, environments=environments)).train.shards

    assert [shards(128), shards(127), shards(129), shards(126), shards(512)] == [2, 1, 1, 1, 2]


def test_a_gpu_takes_all_environments_and_whole_minibatches(tiny, monkeypatch):
    monkeypatch.setattr(street.jax, "devices", lambda: [SimpleNamespace(platform="gpu")] * 2)
    default = shared_out(with_training(tiny, environments=512, chunk_rows=TrainConfig.chunk_rows)).train
    chosen = shared_out(with_training(tiny, environments=512, chunk_rows=4096)).train
    assert (default.shards, default.chunk_rows) == (1, WHOLE_MINIBATCH)
    assert (chosen.shards, chosen.chunk_rows) == (1, 4096)
    several = whole_minibatches(with_training(tiny, shards=2, chunk_rows=TrainConfig.chunk_rows)).train
    assert (several.shards, several.chunk_rows) == (2, WHOLE_MINIBATCH)


def test_every_update_is_told_once(whole, tiny):
    assert [line["update"] for line in whole.metrics()] == [1, 2, 3, 4, 5, 6]
    assert [line["steps"] for line in whole.metrics()] == [64 * n for n in range(1, 7)]
    assert {"goal_rate", "collision_rate", "reward/driver/progress", "driver/kl"} <= whole.metrics()[0].keys()
    assert whole.metrics()[5]["learning_rate"] == pytest.approx(tiny.train.learning_rate / 6)


def test_the_policy_says_where_it_comes_from(whole):
    metadata = read_metadata(whole.policy)
    assert (metadata["recipe"], metadata["seed"], metadata["steps"]) == ("fast", 0, 384)
    assert {"commit", "hardware", "versions"} <= metadata.keys()
    for role in ("driver", "pedestrian"):
        assert load_policy(whole.policy, role).view.name == whole.experiment.train.roles[role].observes


def test_there_are_events_for_tensorboard(whole):
    shown = board(whole.path)
    assert list(shown) == [1, 2, 3, 4, 5, 6]
    assert shown[6]["goal_rate"] == pytest.approx(whole.metrics()[5]["goal_rate"])


def test_resumed_training_equals_uninterrupted(whole, tiny, tmp_path, quiet, stopping, monkeypatch):
    run = Run.create(tmp_path / "cut", tiny)
    stopping(2)
    stopped = train_in(run, display=Display(quiet))
    monkeypatch.undo()
    assert stopped.interrupted
    assert 2 <= stopped.updates < 6
    with (run.path / "metrics.jsonl").open("a") as file:  # a crash after the checkpoint
        file.write('{"update": 5, "seconds": 1}\n{"update": 6, "sec')
    again = Run.open(run.path)
    assert not train_in(again, resume=True, display=Display(quiet)).interrupted
    assert _told(again) == _told(whole)
    assert board(again.path).keys() == board(whole.path).keys()  # no update twice, though 3 and more came again
    _assert_same(again, whole)
    assert again.policy.read_bytes() == whole.policy.read_bytes()


def test_resuming_what_is_finished_changes_nothing(whole, quiet):
    before = {path: path.read_bytes() for path in whole.path.glob("*.json*")}
    assert train_in(whole, resume=True, display=Display(quiet)).updates == 6
    assert {path: path.read_bytes() for path in whole.path.glob("*.json*")} == before


def test_minutes_become_a_number_of_updates(tiny, tmp_path, quiet):
    timed = Run.create(tmp_path / "timed", replace(with_training(tiny, updates=1000), minutes=0.02))
    made = train_in(timed, display=Display(quiet)).updates
    assert Run.open(timed.path).experiment.train.updates == made
    assert timed.metrics()[-1]["learning_rate"] == pytest.approx(tiny.train.learning_rate / made, rel=1e-3)


def test_a_plan_by_minutes_trains_like_that_number_of_updates(whole, tiny, tmp_path, quiet, monkeypatch):
    from jaxwalk.runs import training

    monkeypatch.setattr(training, "plan_by_time", lambda session, learner, limit: replan(session, learner, 6))
    timed = Run.create(tmp_path / "timed", replace(with_training(tiny, updates=1000), minutes=1000.0))
    train_in(timed, display=Display(quiet))
    _assert_same(timed, whole)


def test_a_plan_that_was_shortened_after_the_checkpoint_counts(tiny, tmp_path, quiet, stopping):
    run = Run.create(tmp_path / "cut", tiny)
    stopping(2)
    train_in(run, display=Display(quiet))
    run.describe(with_training(tiny, updates=5))  # then killed
    assert train_in(Run.open(run.path), resume=True, display=Display(quiet)).updates == 5
    assert run.metrics()[-1]["learning_rate"] == pytest.approx(tiny.train.learning_rate / 5, rel=1e-3)


def test_a_training_by_minutes_killed_before_its_plan_is_planned_when_resumed(tiny, tmp_path, quiet, monkeypatch):
    from jaxwalk.runs import training

    def killed(*_):
        raise KeyboardInterrupt

    limits = []

    def plan(session, learner, limit):
        limits.append(limit)
        return replan(session, learner, 2)

    monkeypatch.setattr(training, "plan_by_time", killed)
    run = Run.create(tmp_path / "timed", replace(with_training(tiny, updates=1000), minutes=7.0))
    with pytest.raises(KeyboardInterrupt):
        train_in(run, display=Display(quiet))
    monkeypatch.setattr(training, "plan_by_time", plan)
    assert train_in(Run.open(run.path), resume=True, display=Display(quiet)).updates == 2
    assert limits == [420.0]
    assert Run.open(run.path).experiment == with_training(tiny, updates=2)


def test_a_policy_of_an_earlier_update_is_not_the_end(whole, tiny, tmp_path, quiet, stopping):
    run = Run.create(tmp_path / "cut", tiny)
    stopping(2)
    train_in(run, display=Display(quiet))
    assert is_finished(whole)
    assert not is_finished(run)


def test_a_full_disk_keeps_the_last_checkpoint_and_says_so(whole, tiny, tmp_path, quiet, monkeypatch):
    record, no_room = Session.record, ExitStack()

    def fill(self, metrics, updates, before):
        if updates == 4:
            no_room.enter_context(files_at_most(1))
        record(self, metrics, updates, before)

    monkeypatch.setattr(Session, "record", fill)
    run = Run.create(tmp_path / "full", tiny)
    with no_room, pytest.raises(UnwrittenError) as caught:
        train_in(run, display=Display(quiet), checkpoint_minutes=1e-9)
    assert str(caught.value) == (
        f"{run.path}: training stopped ({run.path / 'metrics.jsonl'}: File too large); the checkpoint of update 3 is "
        f"kept. Remove the cause, then resume with: jaxwalk train --resume {run.path}"
    )
    monkeypatch.undo()
    train_in(Run.open(run.path), resume=True, display=Display(quiet))
    assert _told(run) == _told(whole)
    _assert_same(run, whole)


def test_a_damaged_checkpoint_costs_the_updates_since_the_one_before(whole, tiny, tmp_path, stopping, monkeypatch):
    run, said = Run.create(tmp_path / "cut", tiny), io.StringIO()
    stopping(3)
    train_in(run, display=Display(Console(file=said)), checkpoint_minutes=1e-9)
    monkeypatch.undo()
    newest = run.checkpoints / str(checkpoint.latest(run.checkpoints))
    for file in newest.rglob("*.ocdbt"):
        file.write_bytes(b"")
    train_in(Run.open(run.path), resume=True, display=Display(Console(file=said)))
    assert f"checkpoint {newest.name} can't be read" in said.getvalue()
    assert (run.checkpoints / f"{newest.name}.damaged").is_dir()
    assert _told(run) == _told(whole)
    _assert_same(run, whole)


def test_numbers_that_are_not_finite_stop_training(whole, tiny, tmp_path, quiet, monkeypatch):
    update = mappo.update

    def spoiled(street, config, learner):
        learner, metrics = update(street, config, learner)
        return learner, metrics | {"finite": jnp.where(learner.updates == 4, 0.0, metrics["finite"])}

    monkeypatch.setattr(mappo, "update", spoiled)
    run = Run.create(tmp_path / "spoiled", tiny)
    with pytest.raises(DivergedError, match=r"update 4 gave numbers that are not finite; .* of update 3 are kept"):
        train_in(run, display=Display(quiet))
    assert checkpoint.latest(run.checkpoints) == 3
    assert [line["update"] for line in run.metrics()] == [1, 2, 3]


@pytest.mark.long
def test_the_car_alone_trains_among_always_go(tiny, tmp_path, quiet):
    run = Run.create(tmp_path / "alone", single_agent(with_training(tiny, updates=1)))
    train_in(run, display=Display(quiet))
    assert list(read_metadata(run.policy)["roles"]) == ["driver"]
    assert read_metadata(run.policy)["single_agent"]
    assert "pedestrian/kl" not in run.metrics()[0]
