"""Entries of a leaderboard: what is one, whether it comes out again, and what fresh scenarios say."""

from __future__ import annotations

import shutil
from contextlib import nullcontext

import pytest

from cli.entries import change
from jaxwalk.cli import main
from jaxwalk.experiments import submissions
from jaxwalk.experiments.again import read_document
from jaxwalk.experiments.entry_files import fresh_seed
from jaxwalk.experiments.submissions import read_entry
from jaxwalk.runs.session import CallbackError


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

    change(zoo / "bold" / "results.json", better)
    shutil.copy(zoo / "bold" / "results.json", zoo / "bold" / "checked.json")
    assert main(["submit", "zoo/bold", "--check"]) == 1
    assert "bold: different:" in capsys.readouterr().err
    assert not (zoo / "bold" / "checked.json").exists()


def _as_checked(entry, **scenarios):
    """Put results into an entry as if a check had found them in its fresh scenarios, or in other ones."""
    shutil.copy(entry / "results.json", entry / "checked.json")
    fresh = {"seed": fresh_seed(entry, read_document(entry / "results.json")), **scenarios}
    change(entry / "checked.json", lambda content: content["scenarios"].update(fresh))
    return read_entry(entry).checked


def test_a_salt_is_part_of_a_check(zoo, capsys):
    assert main(["submit", "zoo/bold", "--check", "--salt", "secret"]) == 0
    assert "from a text of whoever checked them (--salt)" in capsys.readouterr().out
    entry, results = zoo / "bold", read_document(zoo / "bold" / "results.json")
    seeds = [fresh_seed(entry, results, salt) for salt in ("secret", "another", None)]
    assert read_document(entry / "checked.json").scenarios.seed == seeds[0] and len({*seeds}) == 3
    for options, shown in (["--salt", "secret"], "yes"), (["--salt", "another"], "no"), ([], "no"):
        assert main(["submit", "zoo/bold", *options]) == 0
        page = capsys.readouterr().out
        assert f"| bold | {shown} |" in page and ("It isn't secret" in page) == (not options)


@pytest.mark.parametrize("error", [KeyError("a bug"), MemoryError(), CallbackError("of a training")])
def test_what_is_no_fault_of_an_entry_ends_the_command(zoo, capsys, monkeypatch, error):
    def evaluate(work, tell):
        raise error

    monkeypatch.setattr(submissions, "evaluate_all", evaluate)
    shutil.copytree(zoo / "bold", zoo / "also")
    with pytest.raises(KeyError) if isinstance(error, KeyError) else nullcontext():
        assert main(["submit", "zoo/bold", "zoo/also", "--check"]) == 2
    assert capsys.readouterr().err.count("jaxwalk: ") == (not isinstance(error, KeyError))


def test_a_check_of_other_results_counts_for_nothing(zoo):
    entry = zoo / "bold"
    assert _as_checked(entry) is not None
    change(entry / "checked.json", lambda content: content["options"].update(driver_acts="sample"))
    assert read_entry(entry).checked is None


def test_a_check_counts_on_the_scenarios_alone_that_follow_from_the_files(zoo):
    entry = zoo / "bold"
    assert _as_checked(entry, seed=7) is None and _as_checked(entry, count=5) is None
    assert _as_checked(entry) is not None
    for step in (
        lambda: (entry / "network.py").write_text("LAYERS = 2"),
        lambda: (entry / "network.py").write_text("LAYERS = 3"),
        lambda: (entry / "network.py").rename(entry / "networks.py"),
        lambda: (entry / "README.md").write_text("It looks at somebody."),
    ):
        step()
        assert read_entry(entry).checked is None
        assert _as_checked(entry) is not None
    (entry / "__pycache__").mkdir()
    (entry / "__pycache__" / "network.pyc").write_bytes(b"")
    assert read_entry(entry).checked is not None


@pytest.mark.parametrize(
    "how",
    [
        lambda content: content["street"]["sim"].update(max_speed=5.0),
        lambda content: content["street"]["maps"][0].update(hash="0" * 16, text="of another street"),
        lambda content: content["populations"][0].update(sha256="0" * 16),
        lambda content: content["cells"][0].update(jaywalk_multiplier=2.0),
        lambda content: content["scenarios"].update(count=5),
    ],
)
def test_one_table_has_one_set_of_rules(zoo, capsys, how):
    shutil.copytree(zoo / "bold", zoo / "also")
    assert main(["submit", "zoo/bold", "zoo/also"]) == 0
    assert capsys.readouterr().out.count("## ") == 1
    change(zoo / "also" / "results.json", how)
    assert main(["submit", "zoo/bold", "zoo/also"]) == 0
    assert capsys.readouterr().out.count("## ") == 2


def test_an_unusable_entry_does_not_end_the_others(zoo, capsys):
    shutil.copytree(zoo / "bold", zoo / "<b>worse\x1b[31m")
    (zoo / "<b>worse\x1b[31m" / "results.json").write_text("{}")
    assert main(["submit", "zoo/nothing", "zoo/<b>worse\x1b[31m", "zoo/bold"]) == 2
    shown = capsys.readouterr()
    assert "| bold | no |" in shown.out
    assert "| nothing | zoo/nothing: no such folder; check the name |" in shown.out
    assert "| &lt;b&gt;worse \\[31m | zoo/&lt;b&gt;worse \\[31m/results.json: " in shown.out
    assert len(shown.err.splitlines()) == 2 and "\x1b" not in shown.out + shown.err


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("submit", "a folder is missing"),
        ("submit nowhere", "nowhere: no such folder"),
        ("submit zoo", "zoo: has no README.md"),
        ("submit zoo/bold zoo/../zoo/bold", "two folders are called bold"),
        ("submit zoo/bold --out board.csv", "must end in .md"),
        ("submit zoo/bold --check --salt=", "--salt is empty"),
    ],
)
def test_bad_input_is_one_message(zoo, capsys, line, said):
    assert main(line.split()) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("how", "said"),
    [
        (lambda content: content["drivers"].append(content["drivers"][0]), "is of 2 drivers"),
        (lambda content: content["scenarios"].update(count=3), "3 scenarios are too few, 4 are needed"),
        (lambda content: content["scenarios"].pop("seed"), "is not of drawn scenarios"),
        (lambda content: content["drivers"][0].update(name="../x.onnx", kind="file"), "../x.onnx is not in zoo/bold"),
        (
            lambda content: content["cells"][0].update(pedestrians="others"),
            "a cell of its results is not of their driver",
        ),
        (
            lambda content: content["cells"][0]["contacts"]["footprint"]["moving"].update(value=None),
            "its results don't say how often the moving car touched somebody",
        ),
        (lambda content: content["drivers"][0].update(name="/x.onnx", kind="file"), "/x.onnx is not in zoo/bold"),
    ],
)
def test_what_is_no_entry_is_refused(zoo, capsys, how, said):
    change(zoo / "bold" / "results.json", how)
    assert main(["submit", "zoo/bold"]) == 2
    assert said in capsys.readouterr().err


def test_a_driver_file_that_was_changed_is_refused(zoo, capsys):
    def claims(content):
        content["drivers"][0].update(name="mine.safetensors", kind="policy file", sha256="0" * 16)
        content["cells"][0].update(driver="mine.safetensors")

    (zoo / "bold" / "mine.safetensors").write_bytes(b"another one")
    change(zoo / "bold" / "results.json", claims)
    assert main(["submit", "zoo/bold", "--check"]) == 2
    assert "zoo/bold: results.json was made with the policy file mine.safetensors" in capsys.readouterr().err
