"""Entries of a leaderboard: what is one, whether it comes out again, and what fresh scenarios say."""

from __future__ import annotations

import json
import shutil
import sys
from contextlib import chdir
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from jaxwalk.cli import main
from jaxwalk.experiments import submissions
from jaxwalk.experiments.again import read_document
from jaxwalk.experiments.entry_files import fresh_seed
from jaxwalk.experiments.submissions import read_entry
from jaxwalk.runs.policy_origins import policy_origin


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with an entry under ``zoo/bold``, of four scenarios."""
    folder = tmp_path_factory.mktemp("made")
    entry = folder / "zoo" / "bold"
    assert main(f"evaluate --driver route-follower --episodes 4 --out {entry}".split()) == 0
    (entry / "README.md").write_text("It looks at nobody.")
    for name in ("suite.md", "episodes.csv"):
        (entry / name).unlink()
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
    assert checked.scenarios.seed == fresh_seed(zoo / "bold", before) != before.scenarios.seed
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
    shutil.copy(zoo / "bold" / "results.json", zoo / "bold" / "checked.json")
    assert main(["submit", "zoo/bold", "--check"]) == 1
    assert "bold: different:" in capsys.readouterr().err
    assert not (zoo / "bold" / "checked.json").exists()


def _as_checked(entry, **scenarios):
    """Put results into an entry as if a check had found them in its fresh scenarios, or in other ones."""
    shutil.copy(entry / "results.json", entry / "checked.json")
    fresh = {"seed": fresh_seed(entry, read_document(entry / "results.json")), **scenarios}
    _change(entry / "checked.json", lambda content: content["scenarios"].update(fresh))
    return read_entry(entry).checked


def test_a_check_of_other_results_counts_for_nothing(zoo):
    entry = zoo / "bold"
    assert _as_checked(entry) is not None
    _change(entry / "checked.json", lambda content: content["options"].update(driver_acts="sample"))
    assert read_entry(entry).checked is None


def test_a_check_counts_on_the_scenarios_alone_that_follow_from_the_files(zoo):
    entry = zoo / "bold"
    assert _as_checked(entry, seed=7) is None and _as_checked(entry, count=5) is None
    assert _as_checked(entry) is not None
    for change in (
        lambda: (entry / "network.py").write_text("LAYERS = 2"),
        lambda: (entry / "network.py").write_text("LAYERS = 3"),
        lambda: (entry / "network.py").rename(entry / "networks.py"),
        lambda: (entry / "README.md").write_text("It looks at somebody."),
    ):
        change()
        assert read_entry(entry).checked is None
        assert _as_checked(entry) is not None
    (entry / "__pycache__").mkdir()
    (entry / "__pycache__" / "network.pyc").write_bytes(b"")
    assert read_entry(entry).checked is not None


@pytest.mark.parametrize(
    "change",
    [
        lambda content: content["street"]["sim"].update(max_speed=5.0),
        lambda content: content["street"]["maps"][0].update(hash="0" * 16, text="of another street"),
        lambda content: content["populations"][0].update(sha256="0" * 16),
        lambda content: content["cells"][0].update(jaywalk_multiplier=2.0),
        lambda content: content["scenarios"].update(count=5),
    ],
)
def test_one_table_has_one_set_of_rules(zoo, capsys, change):
    shutil.copytree(zoo / "bold", zoo / "also")
    assert main(["submit", "zoo/bold", "zoo/also"]) == 0
    assert capsys.readouterr().out.count("## ") == 1
    _change(zoo / "also" / "results.json", change)
    assert main(["submit", "zoo/bold", "zoo/also"]) == 0
    assert capsys.readouterr().out.count("## ") == 2


def test_a_link_is_no_file_of_an_entry(zoo, capsys):
    (zoo / "weights.onnx").touch()
    (zoo / "bold" / "driver.onnx").symlink_to(zoo / "weights.onnx")
    assert main(["submit", "zoo/bold"]) == 2
    assert "zoo/bold/driver.onnx: is a link" in capsys.readouterr().err


def test_an_unusable_entry_does_not_end_the_others(zoo, capsys):
    shutil.copytree(zoo / "bold", zoo / "<b>worse\x1b[31m")
    (zoo / "<b>worse\x1b[31m" / "results.json").write_text("{}")
    assert main(["submit", "zoo/nothing", "zoo/<b>worse\x1b[31m", "zoo/bold"]) == 2
    shown = capsys.readouterr()
    assert "| bold | no |" in shown.out
    assert "| nothing | zoo/nothing: no such folder; check the name |" in shown.out
    assert "| &lt;b&gt;worse \\[31m | zoo/&lt;b&gt;worse \\[31m/results.json: " in shown.out
    assert len(shown.err.splitlines()) == 2 and "\x1b" not in shown.out + shown.err


DRIVER = """
import network

class Driver:
    pedal = network.PEDAL
    def act(self, seen):
        raise ValueError
"""


@pytest.fixture
def of_python(zoo, monkeypatch):
    """Entries of a Python driver with a module, called slow and fast, which aren't played; returns what was loaded."""
    loaded = []

    def evaluated(work, tell):
        (driver,) = work.drivers.values()
        loaded.append(driver._driver.pedal)
        results = read_document(Path("results.json"))
        return replace(results, scenarios=replace(results.scenarios, seed=work.scenarios.seed))

    monkeypatch.setattr(submissions, "evaluate_all", evaluated)
    for name, pedal in (("slow", 0.1), ("fast", 1.0)):
        entry = shutil.copytree(zoo / "bold", zoo / name)
        (entry / "driver.py").write_text(DRIVER)
        (entry / "network.py").write_text(f"PEDAL = {pedal}")
        with chdir(entry):
            origin = asdict(policy_origin("driver", "driver.py:Driver"))

        def claims(content, origin=origin):
            content["drivers"][0] = origin
            content["cells"][0].update(driver=origin["name"])

        _change(entry / "results.json", claims)
    return loaded


def test_entries_may_have_modules_of_the_same_names(of_python, zoo):
    assert main(["submit", "zoo/slow", "zoo/fast", "--check"]) == 0
    assert of_python == [0.1, 0.1, 1.0, 1.0]
    assert not list(zoo.rglob("__pycache__")) and "network" not in sys.modules


def test_a_module_of_elsewhere_is_refused(of_python, zoo, capsys, monkeypatch):
    (zoo / "shared").mkdir()
    (zoo / "fast" / "network.py").rename(zoo / "shared" / "network.py")
    monkeypatch.syspath_prepend(zoo / "shared")
    assert main(["submit", "zoo/fast", "zoo/slow", "--check"]) == 2
    shown = capsys.readouterr()
    assert f"network: the driver imports this module from {zoo / 'shared'}; put it into {zoo / 'fast'}" in shown.err
    assert of_python == [0.1, 0.1]
    assert "| slow | yes |" in shown.out and not (zoo / "fast" / "checked.json").exists()
    assert "network" not in sys.modules


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
        (
            lambda content: content["cells"][0].update(pedestrians="others"),
            "a cell of its results is not of their driver",
        ),
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
        content["cells"][0].update(driver="mine.safetensors")

    (zoo / "bold" / "mine.safetensors").write_bytes(b"another one")
    _change(zoo / "bold" / "results.json", claims)
    assert main(["submit", "zoo/bold", "--check"]) == 2
    assert "zoo/bold: results.json was made with the policy file mine.safetensors" in capsys.readouterr().err
