"""Results say where, with what and by what they were made."""

from __future__ import annotations

import csv
import hashlib
import json
from importlib import resources
from pathlib import Path

import jax
import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.cli import main
from jaxwalk.evaluation.reading import Origin, as_results
from jaxwalk.interfaces import Box
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig
from jaxwalk.maps import MapText, read_map, reference
from jaxwalk.policies import save_policy
from jaxwalk.provenance import commit, versions
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.observation import size

PAPER = resources.files("jaxwalk.maps").joinpath("paper.toml").read_text(encoding="utf-8")
OTHER = PAPER + "\n# a street of one's own\n"


@pytest.mark.long
def test_results_on_two_maps_name_them_everywhere_with_the_rates_on_each(place, capsys):
    (place / "there").mkdir()
    (place / "there" / "town.toml").write_text(OTHER, encoding="utf-8")
    command = "evaluate --driver rule-based --map paper there/town.toml --episodes 20 --out kept"
    assert main(command.split()) == 0
    out = capsys.readouterr().out
    assert "hash" in out and ", on paper, town.toml, 12 pedestrians, collisions by footprint\n" in out
    document = json.loads((place / "kept" / "results.json").read_text())
    town = MapText.of("town.toml", OTHER)
    paper = {"name": "paper", "hash": read_map("paper").hash}
    assert document["street"]["maps"] == [paper, {"name": "town.toml", "hash": town.hash, "text": OTHER}]
    with (place / "kept" / "episodes.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    street = Street.create(["paper", town])
    drawn = Drawn(street, 0, 20).take(np.arange(20))[0].map
    assert [row["map"] for row in rows] == [("paper", "town.toml")[i] for i in np.asarray(drawn)]
    suite = (place / "kept" / "suite.md").read_text()
    assert f"town.toml (hash {town.hash})" in suite and "## On each map" in suite
    by_map = document["cells"][0]["by_map"]
    assert [found["map"] for found in by_map] == ["paper", "town.toml"]
    for found in by_map:
        here = [row["outcome"] for row in rows if row["map"] == found["map"]]
        assert found["episodes"] == len(here) > 0
        for ending in ("goal", "collision", "timeout"):
            assert found[f"{ending}_rate"]["value"] == pytest.approx(here.count(ending) / len(here))
            assert found[f"{ending}_rate"]["low"] <= found[f"{ending}_rate"]["value"] <= found[f"{ending}_rate"]["high"]
        assert f"| rule-based among always-go | {found['map']} | {len(here)} |" in suite
        assert f" {found['map']} " in out


def test_results_say_with_what_they_were_made_and_read_back(place, capsys):
    actor = make_actor(jax.random.key(0), size("driver", "paper"), Box(2), RoleConfig(actor_hidden=(4,)))
    save_policy(place / "mine.safetensors", {"driver": actor}, {})
    command = "evaluate --compare mine.safetensors rule-based --pedestrians learned --episodes 3 --driver-acts sample"
    assert main([*command.split(), "--json"]) == 0
    text = capsys.readouterr().out
    document = json.loads(text)
    sha = hashlib.sha256((place / "mine.safetensors").read_bytes()).hexdigest()[:16]
    assert document["drivers"] == [
        {"name": "mine.safetensors", "kind": "policy file", "sha256": sha},
        {"name": "rule-based", "kind": "rule", "sha256": None},
    ]
    (people,) = document["populations"]
    assert (people["name"], people["kind"], len(people["sha256"])) == ("learned", "shipped policy", 16)
    assert (document["made"]["commit"], document["made"]["versions"]) == (commit(), versions())
    assert document["made"]["hardware"]
    assert document["options"] == {
        "jaywalk_multipliers": [0.25], "driver_acts": "sample", "pedestrians_act": "sample",
        "compare": ["mine.safetensors", "rule-based"], "counterfactuals": 0, "encounters": False,
    }  # fmt: skip
    assert as_results(document, Origin(Path("results.json"), "evaluate again")).to_json() == text


def test_what_is_committed_meanwhile_made_nothing(monkeypatch):
    before = commit()
    monkeypatch.setattr("jaxwalk.provenance._git", lambda *_: "what was committed meanwhile")
    assert commit() == before


def test_where_drivers_of_ones_own_come_from(place):
    for name in ("mine.py", "driver.onnx"):
        (place / name).write_text(name)
    (place / "home").mkdir()
    (place / "home" / "car.py").write_text("car")

    def found(name):
        origin = policy_origin("driver", name)
        return origin.kind, origin.sha256

    def sha(text):
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    assert found("mine.py:Mine") == found("mine:Mine") == ("Python class", sha("mine.py"))
    assert found("home.car:Mine") == ("Python class", sha("car"))
    assert found("driver.onnx") == ("file", sha("driver.onnx"))
    assert found("json:Mine")[0] == "Python class" and found("json:Mine")[1] is not None


def test_a_map_that_only_has_the_name_of_a_bundled_one_keeps_its_text():
    assert reference(read_map("paper")).text is None
    assert reference(MapText.of("paper", OTHER)).text == OTHER
