"""A folder of `jaxwalk reproduce` from somebody else: whatever its files say, one message tells what is wrong."""

from __future__ import annotations

import copy
import json
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from browser.pages import gallery_document, watched
from hostile.judging import command, unfinished
from hostile.mutations import as_json, contents, documents
from jaxwalk.evaluation.reading import Origin, as_document, as_results
from jaxwalk.experiments.reproduce import Plan
from jaxwalk.provenance import Provenance
from jaxwalk.recipes import RECIPES
from jaxwalk.report import Gallery
from jaxwalk.runs.folder import Run
from jaxwalk.runs.study import run_folder
from report.material import material

CASES = 20
ENDINGS = {"goal_rate": 0.5, "collision_rate": 0.25, "timeout_rate": 0.25}
MATERIAL = material(1)
MADE = {
    "plan": asdict(Plan(seed=5, updates=8, episodes=3)),
    "results": MATERIAL.results.as_dict(),
    "ablation": MATERIAL.ablation.as_dict(),
    "provenance": asdict(MATERIAL.provenance),
    "minutes": MATERIAL.minutes,
    "gallery": gallery_document(),
    "episode": asdict(MATERIAL.episode),
}
GOOD = json.loads(json.dumps(MADE, allow_nan=False))
METRICS = "".join(
    json.dumps({"update": n, "steps": 64 * n, "seconds": 1.0 * n, "episodes": float(n)} | ENDINGS) + "\n"
    for n in range(1, 9)
)
PARTS = ("plan", "results", "ablation", "provenance", "minutes", "gallery", "episode")


def _write(folder: Path, changed: dict[str, bytes]) -> None:
    for name in PARTS:
        (folder / f"{name}.json").write_bytes(changed.get(name, json.dumps(GOOD[name]).encode()))
    (folder / "episode.svg").write_text(MATERIAL.episode_svg)
    for name in MATERIAL.curves:
        run = Run.create(run_folder(folder, name, 5), RECIPES["fast"])
        (run.path / "metrics.jsonl").write_bytes(changed.get("metrics", METRICS.encode()))


def _report(changed: dict[str, bytes]) -> str | None:
    with TemporaryDirectory() as place:
        folder = Path(place)
        _write(folder, changed)
        code, message = command(["report", str(folder)])
        assert not unfinished(folder)
        assert (folder / "report.html").is_file() == (code == 0), "there whole, or not at all"
        return message if code else None


@pytest.fixture(autouse=True)
def quick_figures(monkeypatch):
    """Figures are made, but not written, which takes seconds."""
    monkeypatch.setattr("jaxwalk.report.figures.save", lambda *_: "")


def test_a_good_folder_is_reported():
    assert _report({}) is None


def test_documents_read_back_are_the_same():
    origin = Origin(Path("somewhere.json"), "evaluate again")
    for name in ("results", "ablation"):
        read = as_results(GOOD[name], origin)
        assert read == getattr(MATERIAL, name)
        assert json.loads(read.to_json()) == GOOD[name]
    assert as_document(Gallery, GOOD["gallery"], origin).as_dict() == watched(GOOD["gallery"]).as_dict()
    assert asdict(as_document(Provenance, GOOD["provenance"], origin)) == GOOD["provenance"]


def _changed(name, change):
    """The file's content after the change."""
    document = copy.deepcopy(GOOD[name])
    change(document)
    return {name: json.dumps(document).encode()}


def _of_schema_3(document):
    document["schema"] = 3


def _another_judgement(document):
    document["cells"][0]["counterfactuals"]["all"]["judged"]["human"]["value"] = 0.5


def _of_words(document):
    document["cells"][3]["outcomes"]["goal"]["value"] = "0.5"


def _infinite(document):
    document["cells"][0]["attribution"]["per_crossing"]["exposure_jaywalk"] = float("inf")


def _another_headline(document):
    document["cells"][1]["goal_rate"]["value"] = 0.125


def _few_quarters(document):
    del document["cells"][2]["jaywalk_rate"]["quarters"][3]


def _uneven_curve(document):
    document["cells"][0]["surrogate_distributions"]["jaywalk"]["pet"]["low"].append(None)


def _unknown_field(document):
    document["cells"][0]["waiting"]["patience"] = 1


def _too_large(document):
    document["cells"][0]["outcomes"]["goal"]["value"] = 1e40


def _without_a_metric(document):
    for cell in document["cells"]:
        del cell["waiting"]


def _a_cell_without_a_metric(document):
    del document["cells"][1]["waiting"]


def _no_seed(document):
    del document["seed"]


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("results", _of_words, "results.json: damaged (cells.3.outcomes.goal.value: "),
        ("results", _infinite, "results.json: damaged (cells.0.attribution.per_crossing.exposure_jaywalk: "),
        ("results", _too_large, "damaged (cells.0.outcomes.goal.value: the number is not finite or above 1e+39)"),
        ("results", _without_a_metric, "results.json: of another version (it lacks the metric waiting)"),
        ("results", _a_cell_without_a_metric, "results.json: damaged (cells.1.waiting: Field required)"),
        ("results", _another_headline, "results.json: damaged (cells.1.goal_rate: differs from the same number"),
        ("results", _another_judgement, "(cells.0.preventable_share: differs from the same number"),
        ("results", _few_quarters, "results.json: damaged (cells.2.jaywalk_rate.quarters: has 3 entries, not 4)"),
        ("results", _uneven_curve, "(cells.0.surrogate_distributions.jaywalk.pet: has 11 entries, not 10)"),
        ("results", _unknown_field, "results.json: damaged (cells.0.waiting.patience: "),
        ("ablation", _of_schema_3, "ablation.json: of another version (its schema is not 5)"),
        ("episode", _no_seed, "episode.json: damaged (seed: "),
    ],
)  # fmt: skip
def test_the_message_names_the_file_and_the_field(name, change, said):
    message = _report(_changed(name, change))
    assert said in message
    assert message.count("\n") == 1 and "run `jaxwalk reproduce` again" in message


def test_a_training_without_a_metric_is_refused():
    said = _report({"metrics": METRICS.replace('"goal_rate": 0.5, ', "").encode()})
    assert "metrics.jsonl: damaged (update 1 has no goal_rate)" in said


@pytest.mark.long
def test_a_bad_folder_is_refused_in_words():
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
