"""A policy made to share: its results are in it, and its card says the same."""

import json

import pytest

from jaxwalk.evaluation import evaluate_grid
from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.exports.sharing import Judging, share
from jaxwalk.policies import SHIPPED, read_metadata, shipped_policy
from jaxwalk.report.table import shown
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.runs.folder import Run, RunError
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.suites import Where


@pytest.mark.long
def test_file_and_card_tell_what_an_evaluation_finds(whole, tmp_path):
    out = tmp_path / "new" / "mine.safetensors"
    card = share(whole.path, out, Judging(("always-go", str(whole.path)), 6, 3, Where(people=5)))
    about = read_metadata(out)
    assert (about["recipe"], about["seed"], about["maps"]) == ("fast", 0, ["paper"])
    assert set(about["roles"]) == {"driver", "pedestrian"}

    street = world_of([str(whole.path)], Where(people=5))
    drivers, people = {"it": contestant(street, "driver", str(out))}, {"p": contestant(street, "pedestrian", str(out))}
    found, _ = evaluate_grid(street, drivers, people, Drawn(street, 3, 6))
    told = about["results"]["among"]["learned (fast, training seed 0)"]
    assert told["goal_rate"] == json.loads(found.to_json())["cells"][0]["goal_rate"]
    assert about["results"]["scenarios"] == {"seed": 3, "count": 6, "hash": found.scenarios.hash}
    lines = card.read_text().splitlines()
    assert lines[0] == "# mine"
    assert about["results"]["where"].endswith("5 pedestrians, collisions by footprint")
    assert f"on {about['results']['where']}; 95 %" in card.read_text()
    assert any(
        line.startswith(f"| learned (fast, training seed 0) | {100 * told['goal_rate']['value']:.1f} [")
        for line in lines
    )
    assert any("10 steps" in line for line in lines)


def test_a_run_without_a_policy_is_refused(tiny, tmp_path):
    Run.create(tmp_path / "begun", tiny)
    with pytest.raises(RunError, match="has no policy"):
        share(tmp_path / "begun", tmp_path / "x.safetensors", Judging())
    assert not (tmp_path / "x.safetensors").exists()


@pytest.mark.parametrize(("role", "name"), [(role, name) for role, names in SHIPPED.items() for name in names])
def test_what_is_shipped_loads_and_has_its_card(street, role, name):
    file = shipped_policy(role, name)
    policy = contestant(street, role, name)
    assert policy.view.name
    about = read_metadata(file)
    rates = about["results"]["among"]["always-go"]["goal_rate"]
    assert f"| {shown(Interval(**rates))} |" in file.with_suffix(".md").read_text()
    assert file.stem.startswith(f"{about['recipe']}-")


@pytest.mark.long
def test_the_command_and_what_it_refuses(whole, tmp_path, capsys):
    from jaxwalk.cli import main

    out = tmp_path / "mine.safetensors"
    options = ["share", str(whole.path), "--pedestrians", "always-go", str(whole.path), "--episodes", "3", "--out"]
    assert main([*options, str(out)]) == 0
    assert "learned (fast, training seed 0)" in out.with_suffix(".md").read_text()
    (tmp_path / "notes.md").write_text("mine")
    for name, said in (("notes.safetensors", "would replace"), ("mine.txt", "must end in"), ("", "must end in")):
        assert main([*options, str(tmp_path / name)]) == 2
        assert said in capsys.readouterr().err
    assert (tmp_path / "notes.md").read_text() == "mine"
