"""``jaxwalk search``, as a user types it; and ``jaxwalk evaluate --scenarios``."""

from __future__ import annotations

import csv
import dataclasses
import json
from functools import partial

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from jaxwalk.cli import main
from jaxwalk.cli.options import Search
from jaxwalk.experiments import failure_search
from jaxwalk.scenarios.archive_file import HEADER, read_archive, read_tensors
from jaxwalk.search.grid import in_words
from jaxwalk.search.splitting import SplittingPlan

SMALL = 16


@pytest.fixture
def little(monkeypatch):
    """Batches of 16, so that little is played."""
    for module in ("jaxwalk.evaluation.batches", "jaxwalk.experiments.failure_search"):
        monkeypatch.setattr(f"{module}.BATCH", SMALL)


SEARCH = "search route-follower --people 4 --minimise 1 --out there --simulations"


@pytest.mark.long
@pytest.mark.usefixtures("scenario_library")
def test_a_driver_is_searched_and_its_failures_are_played_again(little, place, capsys):
    """Two generations, then interrupted in the third; it goes on, and every failure recurs in an evaluation."""
    assert main(f"{SEARCH} 32".split()) == 0
    said, progress = capsys.readouterr()
    stages = ["compiling", "searching", "playing failures", "who would avoid them?", "minimising", "recording replays"]
    found = [progress.find(stage) for stage in stages]
    assert found == sorted(found) and found[0] == 0
    assert "of failure in 32 scenarios (map-elites)" in said and said.endswith("Open there/search.html\n")
    with pytest.MonkeyPatch.context() as patch:

        def stop(*_):
            raise KeyboardInterrupt

        patch.setattr(failure_search, "play_generation", stop)
        assert main(f"{SEARCH} 48".split()) == 130
        assert "The same command goes on" in capsys.readouterr().err
    assert main(f"{SEARCH} 48".split()) == 0
    document = json.loads((place / "there" / "search.json").read_text())
    assert [row["simulations"] for row in document["log"]] == [16, 32, 48]
    failures = document["failures"]
    assert len({one["cell"] for one in failures}) == len(failures) == document["log"][-1]["cells"] > 1
    assert failures[0]["people"] == 1 and failures[1]["people"] is None
    with (place / "there" / "failures.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["scenario"] for row in rows] == [str(n) for n in range(len(failures))]
    assert [row["cell"] for row in rows] == [str(one["cell"]) for one in failures]
    assert [row["cell_in_words"] for row in rows] == [str(in_words(one["cell"])) for one in failures]
    page = (place / "there" / "search.html").read_text()
    assert page.count('data-episode="') - page.count('data-episode="${') == len(failures)
    capsys.readouterr()
    assert main(["evaluate", "--scenarios", "there", "--driver", "route-follower", "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert results["cells"][0]["collision_rate"]["value"] == 1.0
    assert results["scenarios"] == {"count": len(failures), "hash": document["hash"]}
    assert main(["evaluate", "--scenarios", "there/minimised.safetensors", "--driver", "route-follower", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["cells"][0]["collision_rate"]["value"] == 1.0
    one = "--scenarios there/minimised.safetensors --scenario 0 --driver route-follower"
    assert main(f"scenario {one} --out files".split()) == 0
    assert (place / "files" / "episode.xosc").read_text().count("<Pedestrian ") == 1
    assert main(f"play {one} --html".split()) == 0
    assert "1 episode of there/minimised.safetensors" in capsys.readouterr().out
    assert main(f"scenario {one} --scenario 1".split()) == 2
    assert main(["play", "--scenarios", "there", "--scenario", "99", "--driver", "route-follower"]) == 2
    assert "--scenario 99: the file has scenarios 0 to" in capsys.readouterr().err
    assert main(f"{SEARCH} 48 --seed 4".split()) == 2
    assert "was begun with another value of seed" in capsys.readouterr().err


@pytest.mark.long
def test_how_rare_failures_are(little, place, capsys, monkeypatch):
    monkeypatch.setattr("jaxwalk.search.driving.BATCH", SMALL)
    monkeypatch.setattr("jaxwalk.cli.search.SplittingPlan", partial(SplittingPlan, moves=1))
    line = "search route-follower --people 4 --method splitting --particles 16 --repeats 2 --out there"
    assert main(line.split()) == 0
    assert "the moving car touches somebody in 0." in capsys.readouterr().out
    document = json.loads((place / "there" / "rate.json").read_text())
    assert len(document["rate"]["estimates"]) == 2 and 0.05 < document["rate"]["value"] < 0.95


BAD = {
    "no driver": ("search", "name one driver to search, such as co-trained"),
    "two drivers": ("search random route-follower", "name one driver to search, not 2"),
    "no such driver": ("search nobody", "nobody: no driver of that name"),
    "no scenarios": ("search random --simulations 0", "--simulations must lie in [1,"),
    "one repeat": ("search random --method splitting --repeats 1", "--repeats must lie in [2,"),
    "a suite and a map": ("search random --suite town --map paper", "--map: the suite town decides it"),
    "no file": ("evaluate --driver random --scenarios none", "none: no such file"),
    "an empty folder": ("evaluate --driver random --scenarios empty", "empty: has no scenarios.safetensors; if it is"),
    "another file": ("evaluate --driver random --scenarios text", "text: damaged or no safetensors file"),
    "a seed": ("evaluate --driver random --scenarios text --seed 3", "--seed: --scenarios text decides it"),
}  # fmt: skip


@pytest.mark.parametrize(("words", "message"), BAD.values(), ids=BAD)
def test_what_cannot_be_used_ends_in_one_message(place, capsys, words, message):
    (place / "empty").mkdir()
    (place / "text").write_text("nonsense")
    assert main(words.split()) == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_help_says_every_default(capsys):
    assert main(["search", "--help"]) == 0
    text = capsys.readouterr().out
    assert text.count("(default:") == len(dataclasses.fields(Search))
    assert "how rare failures are" in " ".join(text.split())


def test_evolution_says_what_is_missing(capsys, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main(["search", "random", "--method", "evolution"]) == 2
    assert 'pip install "jaxwalk[search]"' in capsys.readouterr().err


def test_files_that_were_changed_are_refused(street, tmp_path):
    """Each array and the header, changed so that they can't be played."""
    from jaxwalk.scenarios import Archived
    from jaxwalk.scenarios.archive_file import ArchiveError, write_archive
    from jaxwalk.search.cube import ordinary
    from jaxwalk.sim.scenario import dimensions

    points = ordinary(np.random.default_rng(0), 3, dimensions(street.world))
    present = np.ones((3, 12), bool)
    present[1, 4:] = False
    file = tmp_path / "kept.safetensors"
    kept = Archived(street, points, present, 7, np.array([5, 0, 9]))
    write_archive(file, kept, {"note": "three"})
    found = read_archive(file)
    assert found.hash() == kept.hash() and found.seed == 7 and len(found) == 3
    np.testing.assert_array_equal(found.points, points)
    np.testing.assert_array_equal(found.present, present)
    text, arrays = read_tensors(file, HEADER, "file of scenarios")
    header = json.loads(text)
    wrong = {
        "outside": (arrays | {"points": points + 1}, header),
        "not a number": (arrays | {"points": points * np.float32("nan")}, header),
        "too short": (arrays | {"points": points[:, :-1].copy()}, header),
        "doubles": (arrays | {"points": points.astype(np.float64)}, header),
        "flat": (arrays | {"points": points.ravel()}, header),
        "missing": ({"points": points}, header),
        "empty": ({name: array[:0] for name, array in arrays.items()}, header),
        "negative": (arrays | {"keys": arrays["keys"] - 10}, header),
        "kinds": (arrays | {"present": present.astype(np.int64)}, header),
        "format": (arrays, header | {"format": 99}),
        "no map": (arrays, header | {"maps": []}),
        "other map": (arrays, header | {"maps": [{"name": "paper", "hash": "0" * 16, "text": None}]}),
        "people": (arrays, header | {"sim": header["sim"] | {"pedestrians": -1}}),
        "other people": (arrays, header | {"sim": header["sim"] | {"pedestrians": 11}}),
        "seed": (arrays, header | {"seed": -1}),
        "extra": (arrays, header | {"code": "import os"}),
    }
    for name, (spoiled, said) in wrong.items():
        save_file(spoiled, tmp_path / "bad.safetensors", {HEADER: json.dumps(said)})
        with pytest.raises(ValueError) as caught:
            read_archive(tmp_path / "bad.safetensors")
        assert type(caught.value).__module__.startswith("jaxwalk"), name
        assert isinstance(caught.value, ArchiveError) or name == "other map", name
    save_file(load_file(file), tmp_path / "bad.safetensors")
    with pytest.raises(ArchiveError, match="no file of scenarios, as `jaxwalk search` and `jaxwalk live` write them"):
        read_archive(tmp_path / "bad.safetensors")
