"""Entries of a leaderboard: what is one, whether it comes out again, and what fresh scenarios say."""

from __future__ import annotations

import json
import shutil

import pytest

from jaxwalk.cli import main
from jaxwalk.experiments import submissions
from jaxwalk.experiments.again import read_document
from jaxwalk.experiments.submissions import fresh_seed, read_entry


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with an entry under ``zoo/bold``, of four scenarios."""
    folder = tmp_path_factory.mktemp("made")
    entry = folder / "zoo" / "bold"
    assert main(f"evaluate --driver route-follower --episodes 4 --out {entry}".split()) == 0
    (entry / "README.md").write_text("It looks at nobody.")
    return folder


@pytest.fixture
def zoo(made, tmp_path, monkeypatch):
    """A copy of it; four scenarios are enough here."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(submissions, "FEWEST", 4)
    return tmp_path / "zoo"


def _change(path, change):
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))


def test_an_entry_is_checked_and_shown(zoo, capsys):
    assert main(["submit", "zoo/bold"]) == 0
    assert "| bold | no |" in capsys.readouterr().out
    assert main(["submit", "zoo/bold", "--check"]) == 0
    shown = capsys.readouterr()
    assert "bold: equal, with the same versions and processor" in shown.err
    before, checked = read_document(zoo / "bold" / "results.json"), read_document(zoo / "bold" / "checked.json")
    assert checked.scenarios.seed == fresh_seed(before) != before.scenarios.seed
    assert checked.scenarios.count == 4 and checked.scenarios.hash != before.scenarios.hash
    assert "| bold | yes |" in shown.out and checked.scenarios.name in shown.out

    shutil.copytree(zoo / "bold", zoo / "also")
    (zoo / "also" / "checked.json").unlink()
    assert main(["submit", "zoo/also", "zoo/bold", "--out", "leaderboard.md"]) == 0
    rows = [
        line.split(" | ")[:2]
        for line in (zoo.parent / "leaderboard.md").read_text().splitlines()
        if "| rule" in line or "(rule)" in line
    ]
    assert rows == [["| bold", "yes"], ["| also", "no"]]


def test_what_does_not_come_out_again_is_said_and_nothing_is_kept(zoo, capsys):
    def better(content):
        for place in (content["cells"][0], content["cells"][0]["outcomes"]):
            for name in ("goal", "goal_rate"):
                if name in place:
                    place[name]["value"] = 0.5 * place[name]["value"] + 0.5

    _change(zoo / "bold" / "results.json", better)
    assert main(["submit", "zoo/bold", "--check"]) == 1
    assert "bold: different:" in capsys.readouterr().err
    assert not (zoo / "bold" / "checked.json").exists()


def test_a_check_of_other_results_counts_for_nothing(zoo):
    entry = zoo / "bold"
    shutil.copy(entry / "results.json", entry / "checked.json")
    assert read_entry(entry).checked is not None
    _change(entry / "checked.json", lambda content: content["options"].update(driver_acts="sample"))
    assert read_entry(entry).checked is None


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("submit", "a folder is missing"),
        ("submit nowhere", "nowhere: no such folder"),
        ("submit zoo", "zoo: has no README.md"),
        ("submit zoo/bold zoo/../zoo/bold", "two folders are called bold"),
        ("submit zoo/bold --out board.csv", "must end in .md"),
    ],
)
def test_bad_input_is_one_message(zoo, capsys, line, said):
    assert main(line.split()) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda content: content["drivers"].append(content["drivers"][0]), "is of 2 drivers"),
        (lambda content: content["scenarios"].update(count=3), "3 scenarios are too few, 4 are needed"),
        (lambda content: content["scenarios"].pop("seed"), "is not of drawn scenarios"),
        (lambda content: content["drivers"][0].update(name="../x.onnx", kind="file"), "../x.onnx is not in zoo/bold"),
        (lambda content: content["drivers"][0].update(name="/x.onnx", kind="file"), "/x.onnx is not in zoo/bold"),
    ],
)
def test_what_is_no_entry_is_refused(zoo, capsys, change, said):
    _change(zoo / "bold" / "results.json", change)
    assert main(["submit", "zoo/bold"]) == 2
    assert said in capsys.readouterr().err


def test_a_driver_file_that_was_changed_is_refused(zoo, capsys):
    def claims(content):
        content["drivers"][0].update(name="mine.safetensors", kind="policy file", sha256="0" * 16)

    (zoo / "bold" / "mine.safetensors").write_bytes(b"another one")
    _change(zoo / "bold" / "results.json", claims)
    assert main(["submit", "zoo/bold", "--check"]) == 2
    assert "zoo/bold: results.json was made with the policy file mine.safetensors" in capsys.readouterr().err
