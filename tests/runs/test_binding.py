"""A checkpoint is bound to its configuration: an edited one is refused by name, whatever it says is finished."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from jaxwalk.cli import main
from jaxwalk.learning import checkpoint
from jaxwalk.policies import read_metadata
from jaxwalk.recipes import with_training
from jaxwalk.runs import training
from jaxwalk.runs.binding import EditedConfigError, check_bound, policy_bound_to
from jaxwalk.runs.contestants import world_of
from jaxwalk.runs.folder import HASH, Run, config_hash
from jaxwalk.runs.training import is_finished

TRAINED = Path(__file__).parents[1] / "compat" / "recorded" / "trained"
"""A run folder of version 0.1."""


@pytest.fixture
def run(whole, tmp_path):
    """A copy of a finished training."""
    shutil.copytree(whole.path, tmp_path / "run")
    return Run.open(tmp_path / "run")


def _edit(run, *where, to):
    path = run.path / "config.json"
    document = inner = json.loads(path.read_text())
    for name in where[:-1]:
        inner = inner[name]
    inner[where[-1]] = to
    path.write_text(json.dumps(document))
    return Run.open(run.path)


def _check(run):
    said = []
    check_bound(run, run.maps(), said.append)
    return said


@pytest.mark.parametrize(
    ("where", "value"),
    [
        (("seed",), 1),
        (("train", "learning_rate"), 0.5),
        (("train", "updates"), 12),
        (("train", "updates"), 3),
        (("train", "roles", "driver", "actor_hidden"), [9]),
        (("sim", "max_speed"), 5.0),
        (("minutes",), 3.0),
    ],
)
def test_an_edited_configuration_of_a_finished_training_is_refused_by_name(run, where, value, capsys):
    edited = _edit(run, *where, to=value)
    assert not is_finished(edited)
    before = {path: path.read_bytes() for path in run.path.rglob("*") if path.is_file()}
    assert main(["train", "--resume", str(run.path)]) == 2
    err = " ".join(capsys.readouterr().err.split())
    assert "Trained" not in err
    assert f"config.json was edited since checkpoint 6 was made ({'.'.join(where)}); undo the change to resume" in err
    assert {path: path.read_bytes() for path in run.path.rglob("*") if path.is_file()} == before


def test_a_training_stays_finished_when_a_later_version_has_more_fields(run, monkeypatch):
    document = json.loads((run.path / "config.json").read_text())
    del document[HASH], document["sim"]["max_braking"]
    older = config_hash(document)
    (run.path / "config.json").write_text(json.dumps(document | {HASH: older}))
    monkeypatch.setattr(training, "read_metadata", lambda path: {"updates": 6, "config_hash": older})
    again = Run.open(run.path)
    assert again.intact and is_finished(again)
    assert policy_bound_to(again, run.maps())["config_hash"] == older


def test_neither_is_an_edited_one_evaluated(run):
    with pytest.raises(EditedConfigError, match=r"config.json was edited since its policy was trained; undo"):
        world_of([str(_edit(run, "sim", "max_speed", to=5.0).path)])


def test_an_edit_that_hides_the_hash_is_refused_too(run):
    config = json.loads((run.path / "config.json").read_text())
    del config["hash"]
    (run.path / "config.json").write_text(json.dumps({**config, "seed": 4}))
    with pytest.raises(EditedConfigError, match=r"\(seed\)"):
        _check(Run.open(run.path))


def test_another_order_and_layout_is_no_change(run):
    config = json.loads((run.path / "config.json").read_text())
    (run.path / "config.json").write_text(json.dumps(dict(reversed(config.items()))))
    assert _check(Run.open(run.path)) == []


def test_a_plan_that_the_training_changed_itself_is_no_edit(run):
    run.describe(with_training(run.experiment, updates=5))
    assert _check(Run.open(run.path)) == []


def test_other_maps_with_right_hashes_are_refused(run):
    kept = json.loads((run.path / "maps.json").read_text())
    from jaxwalk.maps import text_hash

    text = kept[0]["text"] + "# another street\n"
    (run.path / "maps.json").write_text(json.dumps([{**kept[0], "text": text, "hash": text_hash(text)}]))
    with pytest.raises(EditedConfigError, match="the content of the maps"):
        _check(run)


def test_a_checkpoint_of_an_older_version_is_resumed_with_a_warning(tmp_path):
    shutil.copytree(TRAINED, tmp_path / "old")
    said = []
    old = Run.open(tmp_path / "old")
    check_bound(old, old.maps(said.append), said.append)
    assert len(said) == 2
    assert "keeps no maps" in said[0]
    assert said[1].endswith("checkpoint 2 doesn't say with which configuration it was made; config.json is believed")


def test_checkpoint_and_policy_hold_what_they_were_made_with(run):
    about = checkpoint.kept_with(run.checkpoints, 6)
    assert about["configuration"]["train"]["updates"] == 6
    config, metadata = json.loads((run.path / "config.json").read_text()), read_metadata(run.policy)
    assert metadata["config_hash"] == config["hash"]
    assert (metadata["maps"], metadata["map_hashes"]) == (["paper"], about["maps"])
    assert "jaxwalk" in metadata["versions"] and "commit" in metadata
