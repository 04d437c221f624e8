"""The command line: help at once, documents that repeat, files as promised."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import subprocess
import sys

import pytest

from jaxwalk.cli import main
from jaxwalk.cli.casting import cast
from jaxwalk.cli.options import (
    Bench,
    CoTraining,
    Evaluate,
    Export,
    Frontier,
    Generalisation,
    HiddenIntent,
    Observations,
    Play,
    Reproduce,
    Streets,
    Train,
)
from jaxwalk.cli.train import make_experiment
from jaxwalk.runs.street import make_street


def test_version(capsys):
    from importlib.metadata import version

    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"jaxwalk {version('jaxwalk')}\n"


@pytest.mark.parametrize(
    "command",
    [
        Train,
        Evaluate,
        Play,
        Reproduce,
        HiddenIntent,
        CoTraining,
        Generalisation,
        Frontier,
        Observations,
        Streets,
        Bench,
    ],
)
def test_help_says_every_default(command, capsys):
    name = {HiddenIntent: "hidden-intent", CoTraining: "co-training"}.get(command, command.__name__.lower())
    assert main([name, "--help"]) == 0
    text = capsys.readouterr().out
    assert text.count("(default:") == len(dataclasses.fields(command))
    assert "None" not in text


def test_help_of_export_says_what_to_name(capsys):
    assert main(["export", "--help"]) == 0
    text = capsys.readouterr().out
    assert text.count("(default:") == len(dataclasses.fields(Export)) - 1  # all but the policy
    assert "POLICY" in text


@pytest.mark.parametrize(
    ("platform", "given", "folder"),
    [
        ("linux", {"XDG_CACHE_HOME": "kept"}, "kept/jaxwalk"),
        ("linux", {"HOME": "me"}, "me/.cache/jaxwalk"),
        ("darwin", {"HOME": "me"}, "me/Library/Caches/jaxwalk"),
        ("win32", {"LOCALAPPDATA": "mine"}, "mine/jaxwalk/cache"),
    ],
)
def test_compiled_code_is_kept_where_the_platform_has_its_caches(platform, given, folder, place, monkeypatch):
    for name in ("JAX_COMPILATION_CACHE_DIR", "JAX_ENABLE_COMPILATION_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.3")
    for name, value in given.items():
        monkeypatch.setenv(name, str(place / value))
    monkeypatch.setattr(sys, "platform", platform)
    assert main(["observations"]) == 0
    assert os.environ["JAX_COMPILATION_CACHE_DIR"] == str(place / folder)


@pytest.mark.parametrize(("given", "kept"), [(None, "0"), ("0.3", "0.3")])
def test_programs_that_compile_quickly_are_kept_too_unless_the_user_says_otherwise(given, kept, place, monkeypatch):
    name = "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"
    monkeypatch.setenv(name, given or "")
    if given is None:
        monkeypatch.delenv(name)
    assert main(["observations"]) == 0
    assert os.environ[name] == kept


def test_help_loads_no_jax():
    code = "import sys; from jaxwalk.cli import main; main(['train', '--help']); assert 'jax' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=False).returncode == 0


def test_an_evaluation_repeats_itself(place, capsys):
    command = "evaluate --driver rule-based --pedestrians always-go --episodes 3 --seed 7 --json"
    assert main([*command.split(), "--out", "kept"]) == 0
    first = capsys.readouterr().out
    assert main(command.split()) == 0
    assert capsys.readouterr().out == first
    assert (place / "kept" / "results.json").read_text() == first
    document = json.loads(first)
    assert document["schema"] == 5
    assert document["scenarios"].keys() == {"seed", "count", "hash"}
    assert document["cells"][0]["goal_rate"].keys() == {"value", "low", "high"}
    rows = (place / "kept" / "episodes.csv").read_text().splitlines()
    assert len(rows) == 4
    assert rows[0].startswith("scenario,")


def test_the_table_shows_intervals_and_the_hash(capsys):
    command = "evaluate --driver rule-based --pedestrians always-go --episodes 3 --seed 7 --jaywalk-multiplier 0 1"
    assert main(command.split()) == 0
    out = capsys.readouterr().out
    assert out.count("rule-based") == 2
    assert "3 scenarios of seed 7, hash " in out
    assert "[" in out


@pytest.mark.long
def test_a_world_says_how_often_people_jaywalk_and_the_option_wins(capsys):
    command = "evaluate --driver route-follower --world blind-corner --episodes 2 --seed 7 --json"
    for option, expected in (("", [1.0]), (" --jaywalk-multiplier 0 0.5", [0.0, 0.5])):
        assert main((command + option).split()) == 0
        document = json.loads(capsys.readouterr().out)
        assert [cell["jaywalk_multiplier"] for cell in document["cells"]] == expected
        assert document["options"]["jaywalk_multipliers"] == expected
    street, _, _ = cast(["route-follower"], ["always-go"], Play(world="blind-corner"))
    assert street.config.jaywalk_multiplier == 1
    street, _, _ = cast(["route-follower"], ["always-go"], Play(world="blind-corner", jaywalk_multiplier=0.5))
    assert street.config.jaywalk_multiplier == 0.5
    assert make_experiment(Train(world="blind-corner")).jaywalk_multiplier is None
    assert make_street(make_experiment(Train(world="blind-corner"))).config.jaywalk_multiplier == 1
    assert make_street(make_experiment(Train(jaywalk_multiplier=0.5))).config.jaywalk_multiplier == 0.5


OWN = """
import numpy as np

class Mine:
    batches = 0
    def reset(self, episodes):
        self.batches, self.step = self.batches + 1, 0
    def act(self, observation):
        self.step += 1
        action = np.zeros((len(observation), 2))
        action[:, 0] = 1
        return action[:, self.batches > 1 and self.step == 3 :]
"""


def test_a_driver_of_ones_own_is_evaluated_and_its_cost_shown(place, capsys):
    (place / "mine.py").write_text(OWN)
    assert main(["evaluate", "--driver", "mine:Mine", "--episodes", "3", "--seed", "7", "--out", "kept"]) == 0
    cell = json.loads((place / "kept" / "results.json").read_text())["cells"][0]
    assert (cell["driver"], cell["driver_observes"]) == ("mine:Mine", "paper")
    assert f"mine:Mine: {cell['driver_ms_per_step']:.3g} ms for a step of 16 episodes" in capsys.readouterr().out


@pytest.mark.long
def test_what_was_evaluated_before_a_driver_failed_is_kept(place, capsys):
    (place / "mine.py").write_text(OWN)
    assert main(["evaluate", "--driver", "mine.py:Mine", "--episodes", "20", "--seed", "7", "--out", "kept"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    message = " ".join(err.split())
    assert "jaxwalk: mine.py:Mine: act returned shape (16, 1); return an array of shape (16, 2)" in message
    assert "(scenario 16 and 15 others, played together, step 2); what was evaluated before, 16 episodes, is" in message
    assert sorted(path.name for path in (place / "kept").iterdir()) == [".lock", "episodes-partial.csv"]
    assert len((place / "kept" / "episodes-partial.csv").read_text().splitlines()) == 1 + 16


def test_observations_are_listed(capsys):
    assert main(["observations", "--role", "pedestrian"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "paper: 20 features"
    assert lines[1] == "     0 to    1  position        width of the map, height of the map"
    assert lines[9].split() == ["18", "to", "19", "nearest_other", "60", "m"]
    assert main(["observations"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "    10 to   33  people          (2 x 60 m, 2 x 8.33 m/s) x 6" in lines
    assert "    40 to   57  if_they_turn    3 x 10 m, 12 x 0.5 m, 3 x 3 s" in lines
    assert max(map(len, lines)) <= 100


def test_two_drivers_are_compared_in_words_and_everything_is_kept(place, capsys):
    command = "evaluate --compare rule-based random --episodes 3 --seed 7 --out kept --encounters --counterfactuals 1"
    assert main(command.split()) == 0
    out = capsys.readouterr().out
    assert out.count("3 scenarios") == 3  # two tests, and which scenarios they were
    assert {file.name for file in (place / "kept").iterdir()} == {
        ".lock", "encounters.parquet", "episodes.csv", "results.json", "suite.md",
    }  # fmt: skip
    suite = (place / "kept" / "suite.md").read_text()
    assert "| rule-based among always-go |" in suite and "Made at commit" in suite
    document = json.loads((place / "kept" / "results.json").read_text())
    assert all("counterfactuals" in cell for cell in document["cells"])
    for cell in document["cells"]:
        judged = cell["counterfactuals"]["all"]["judged"]["human"]
        assert cell["preventable_share"] == {name: judged[name] for name in ("value", "low", "high")}
    assert "preventable %" in out
    assert out.count("no contact was replayed") == suite.count("no contact was replayed") > 0
    assert "## Would a careful human have avoided it?" in suite
    compared = document["compared"]
    for one in compared:
        assert one["in_words"] in suite and one["in_words"] in out
    assert [(one["a"], one["b"], one["ending"]) for one in compared] == [
        ("rule-based", "random", "collision"), ("rule-based", "random", "goal"),
    ]  # fmt: skip


def test_play_draws(place, capsys):
    assert main(["play", "--driver", "rule-based", "--scenario", "2", "--out", "there/episode.png"]) == 0
    assert (place / "there" / "episode.png").read_bytes().startswith(b"\x89PNG")
    said = capsys.readouterr().out
    assert "scenario 2 of seed 0" in said and "replaces" not in said
    assert main(["play", "--driver", "rule-based", "--scenario", "2", "--out", "there/episode.png"]) == 0
    assert "(replaces an older file)" in capsys.readouterr().out


@pytest.mark.long
def test_play_makes_a_page_of_several_drivers_and_scenarios(place, capsys):
    command = "play --driver route-follower rule-based --scenario 2 5 2 --out there/replay.html"
    assert main(command.split()) == 0
    said = "4 episodes of seed 0, route-follower, rule-based among always-go"
    assert said in capsys.readouterr().out
    text = (place / "there" / "replay.html").read_text(encoding="utf-8")
    document = json.loads(text.split('id="data">')[1].split("</script>")[0])
    shown = [(e["driver"], e["scenario"]) for e in document["episodes"]]
    assert shown == [("route-follower", 2), ("route-follower", 5), ("rule-based", 2), ("rule-based", 5)]
    assert not re.search(r'(src|href)="(https?:)?//', text)


@pytest.mark.long
def test_a_report_on_a_driver(place, capsys):
    command = "report route-follower --pedestrians always-go --episodes 40 --incidents 3 --counterfactuals 2 --out mine"
    assert main(command.split()) == 0
    assert capsys.readouterr().out == "Open mine/report.html\n"
    folder = place / "mine"
    assert {p.name for p in folder.iterdir()} == {
        ".lock", "report.html", "results.json", "episodes.csv", "figures", "tables",
    }  # fmt: skip
    results = json.loads((folder / "results.json").read_text())
    hits = results["cells"][0]["outcomes"]["all"]["per_km"]["count"]
    assert hits > 3
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert "paper (hash " in text and "route-follower (rule)" in text
    document = json.loads(text.split('id="data">')[1].split("</script>")[0])
    kinds = [(one["kind"], one["avoidable"] is not None) for one in document["incidents"]]
    assert kinds == [("collision", True)] * 3 + [("near miss", False)] * 3
    for one in document["incidents"][:3]:
        episode = document["episodes"][one["episode"]]
        assert episode["ending"] == "collision"
        assert one["t"] == pytest.approx(episode["steps"] * 0.1)
