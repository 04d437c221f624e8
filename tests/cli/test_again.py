"""An evaluation is made again from its document: equal, nearly equal or different, and it says which."""

from __future__ import annotations

import json
import shutil
from importlib import resources
from pathlib import Path

import jax
import pytest

from jaxwalk.cli import main
from jaxwalk.experiments.again import AgainError, compare_documents, evaluation_again, read_document
from jaxwalk.interfaces import Box
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig
from jaxwalk.maps import MapError
from jaxwalk.policies import save_policy
from jaxwalk.sim.observation import size

pytestmark = pytest.mark.long

PAPER = resources.files("jaxwalk.maps").joinpath("paper.toml").read_text(encoding="utf-8")
COMMAND = (
    "evaluate --compare mine.safetensors rule-based --episodes 3 --seed 7 --jaywalk-multiplier 0 1 --map town.toml "
    "--driver-acts sample --counterfactuals 1 --out kept"
)


def _save(path, seed):
    actor = make_actor(jax.random.key(seed), size("driver", "paper"), Box(2), RoleConfig(actor_hidden=(4,)))
    save_policy(path, {"driver": actor}, {})


@pytest.fixture(scope="module")
def evaluated(tmp_path_factory):
    """A folder with an evaluation under ``kept`` and its policy file, but without the map that it was made on."""
    folder = tmp_path_factory.mktemp("evaluated")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        _save(folder / "mine.safetensors", 0)
        (folder / "town.toml").write_text(PAPER, encoding="utf-8")
        assert main(COMMAND.split()) == 0
        (folder / "town.toml").unlink()
    return folder


@pytest.fixture
def kept(evaluated, place):
    """A copy of it in the working folder."""
    shutil.copytree(evaluated, place, dirs_exist_ok=True)
    return Path("kept") / "results.json"


def _change(path, change):
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


def _again(path):
    return main(["evaluate", "--again", str(path)])


def test_the_same_document_comes_out_again(kept, place, capsys):
    assert main(["evaluate", "--again", str(kept), "--out", "new"]) == 0
    assert capsys.readouterr().out == "kept/results.json: equal, with the same versions and processor\n"
    for name in ("results.json", "suite.md", "episodes-x0.csv", "episodes-x1.csv"):
        assert (place / "new" / name).read_bytes() == (place / "kept" / name).read_bytes()


def test_another_number_ends_with_1_and_is_named(kept, monkeypatch, capsys):
    """The evaluation comes out as it did before, as the test above shows."""

    def change(document):
        document["cells"][0]["outcomes"]["kilometres"] *= 1.01

    found = read_document(kept)
    monkeypatch.setattr("jaxwalk.cli.evaluate.evaluate_all", lambda work, tell: found)
    _change(kept, change)
    assert _again(kept) == 1
    out = capsys.readouterr().out
    assert "different: 1 of its values differ by more than 0.0001, with the same versions and processor. " in out
    assert "cells[0].outcomes.kilometres is " in out


def _compared(path, change):
    now = read_document(path)
    _change(path, change)
    return compare_documents(read_document(path), now)


def test_other_versions_within_the_tolerance_are_said(kept):
    def change(document):
        document["made"]["versions"]["jax"] = "0.0.1"
        document["cells"][1]["outcomes"]["kilometres"] *= 1 + 1e-6

    found = _compared(kept, change)
    assert not found.differs
    version = jax.__version__
    said = f"not equal, but every number within 0.0001; made otherwise: jax 0.0.1, now {version}. cells[1].outcomes"
    assert found.in_words.startswith(said)


def test_an_equal_document_of_another_processor_is_equal(kept):
    found = _compared(kept, lambda document: document["made"].update(hardware="an abacus"))
    assert not found.differs
    assert found.in_words.startswith("equal; made otherwise: processor an abacus, now ")


def test_a_number_that_is_missing_or_words_that_differ_are_different(kept):
    assert _compared(kept, lambda d: d["cells"][0].update(driver_observes="route")).differs
    assert _compared(kept, lambda d: d["cells"].pop()).differs


@pytest.mark.parametrize("change", ["missing", "other"])
def test_a_policy_that_is_missing_or_another_one_is_refused(kept, place, capsys, change):
    (place / "mine.safetensors").unlink()
    said = "was made with the policy file mine.safetensors, which is missing; put it there"
    if change == "other":
        _save(place / "mine.safetensors", 1)
        said = "was made with the policy file mine.safetensors of SHA-256 "
    assert _again(kept) == 2
    err = " ".join(capsys.readouterr().err.split())
    assert f"kept/results.json {said}" in err
    assert err.count("jaxwalk: ") == 1


def test_a_document_that_does_not_say_how_it_was_made_is_refused(kept):
    for name in ("street", "options"):
        results = read_document(kept)
        with pytest.raises(AgainError, match=r"results.json: doesn't say how it was made: .*; evaluate anew"):
            evaluation_again(kept, _without(results, name), out=None)


def _without(results, name):
    from dataclasses import replace

    return replace(results, **{name: None})


def test_an_edited_map_is_refused(kept, capsys):
    def change(document):
        document["street"]["maps"][0]["text"] += "# another\n"

    _change(kept, change)
    with pytest.raises(MapError, match=r"town\.toml has 1 fault"):
        evaluation_again(kept, read_document(kept), out=None)


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("evaluate --again nowhere.json", "nowhere.json: no such file; check the name"),
        ("evaluate --again mine.safetensors", "mine.safetensors: is no JSON document"),
        ("evaluate --again kept/results.json --episodes 4", "--episodes: --again evaluates as kept/results.json says"),
        ("evaluate --again kept/results.json --out kept", "--out kept: would replace kept/results.json"),
    ],
)
def test_what_cannot_be_made_again_is_refused(kept, place, capsys, command, message):
    before = {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
    assert main(command.split()) == 2
    assert message in " ".join(capsys.readouterr().err.split())
    assert {path: path.read_bytes() for path in place.rglob("*") if path.is_file()} == before
