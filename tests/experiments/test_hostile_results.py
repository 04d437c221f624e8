"""A folder of `jaxwalk reproduce` from somebody else: whatever its files say, one message tells what is wrong."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from hostile.judging import command, unfinished
from hostile.mutations import as_json, contents, documents
from jaxwalk.experiments.reproduce import Plan
from jaxwalk.runs.folder import Run
from jaxwalk.runs.recipes import RECIPES
from jaxwalk.runs.study import run_folder
from report.material import material

CASES = 20
GOOD = material(1) | {"plan": asdict(Plan(seed=5, updates=8, episodes=3)), "gallery": {"incidents": []}}
PARTS = ("plan", "results", "ablation", "provenance", "minutes", "gallery", "episode")


def _write(folder: Path, changed: dict[str, bytes]) -> None:
    for name in PARTS:
        (folder / f"{name}.json").write_bytes(changed.get(name, json.dumps(GOOD[name]).encode()))
    (folder / "episode.svg").write_text(GOOD["episode_svg"])
    for name, curves in GOOD["curves"].items():
        run = Run.create(run_folder(folder, name, 5), RECIPES["fast"])
        (run.path / "metrics.jsonl").write_bytes(b"".join(as_json(line) + b"\n" for line in curves[5]))


def _report(changed: dict[str, bytes]) -> str | None:
    with TemporaryDirectory() as place:
        folder = Path(place)
        _write(folder, changed)
        code, message = command(["report", str(folder)])
        assert not unfinished(folder)
        assert (folder / "report.html").is_file() == (code == 0), "there whole, or not at all"
        return message if code else None


def test_a_good_folder_is_reported(monkeypatch):
    monkeypatch.setattr("jaxwalk.report.write.draw_all", _no_figures)
    assert _report({}) is None


def test_an_episode_without_its_seed(monkeypatch):
    monkeypatch.setattr("jaxwalk.report.write.draw_all", _no_figures)
    assert "'dict object' has no attribute 'seed'" in str(_report({"episode": b'{"scenario": 2, "training_seed": 5}'}))


def test_a_bad_folder_is_refused_in_words(monkeypatch):
    monkeypatch.setattr("jaxwalk.report.write.draw_all", _no_figures)  # (drawing takes seconds)
    messages = []

    @settings(
        max_examples=CASES, deadline=None, derandomize=True, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(st.sampled_from(PARTS).flatmap(_spoiled))
    def check(changed):
        messages.append(_report(changed))

    check()
    assert any(messages)


def _spoiled(name):
    written = documents(GOOD[name]).map(as_json) | contents(json.dumps(GOOD[name]).encode())
    return written.map(lambda content: {name: content})


def _no_figures(names, *_):
    return dict.fromkeys(names, "")
