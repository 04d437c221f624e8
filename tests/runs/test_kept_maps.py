"""A run folder keeps its maps: it can be copied without them, and a changed map file changes nothing."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from importlib import resources

import pytest

from jaxwalk.cli import main
from jaxwalk.maps import MapError, read_map
from jaxwalk.runs.contestant_names import ContestantError
from jaxwalk.runs.contestants import world_of
from jaxwalk.runs.folder import Run
from jaxwalk.runs.kept_maps import KeptMapsError
from jaxwalk.sim.suites import Where

PAPER = resources.files("jaxwalk.maps").joinpath("paper.toml").read_text(encoding="utf-8")
OTHER = PAPER.replace("left_turn_radius = 8.0", "left_turn_radius = 7.5")


def _silent(line):
    pytest.fail(line)


@pytest.fixture
def town(whole, tmp_path):
    """A trained run on a map file of one's own, which has the paper's text."""
    file = tmp_path / "town.toml"
    file.write_text(PAPER, encoding="utf-8")
    run = Run.create(tmp_path / "run", replace(whole.experiment, maps=(str(file),)))
    shutil.copy(whole.policy, run.policy)
    return run


@pytest.mark.long
def test_a_copied_run_folder_evaluates_to_the_same_document_without_its_map_file(town, tmp_path, capsys, monkeypatch):
    command = "evaluate --driver run --pedestrians run --episodes 3"

    def document(folder):
        monkeypatch.chdir(folder)
        assert main([*command.split(), "--json"]) == 0
        out, err = capsys.readouterr()
        assert err.strip() == ""
        return out

    before = document(tmp_path)
    shutil.copytree(town.path, tmp_path / "elsewhere" / "run")
    (tmp_path / "town.toml").unlink()
    assert document(tmp_path / "elsewhere") == before


def test_another_map_in_the_place_of_the_runs_changes_nothing(town, tmp_path):
    assert OTHER != PAPER
    (tmp_path / "town.toml").write_text(OTHER, encoding="utf-8")
    (found,) = world_of([str(town.path)], tell=_silent).maps
    assert (found.name, found.text) == ("town.toml", PAPER)
    (chosen,) = world_of([str(town.path)], Where((str(tmp_path / "town.toml"),)), tell=_silent).maps
    assert (chosen.name, chosen.text) == ("town.toml", OTHER)


def test_maps_of_one_name_are_told_apart_by_their_hashes(town, tmp_path):
    (tmp_path / "town.toml").write_text(OTHER, encoding="utf-8")
    other = Run.create(tmp_path / "other", town.experiment)
    hashes = [run.maps(_silent)[0].hash for run in (town, other)]
    with pytest.raises(ContestantError) as caught:
        world_of([str(town.path), str(other.path)])
    assert "(town.toml ({}), town.toml ({}))".format(*hashes) in str(caught.value)


def test_equal_maps_in_two_places_are_one_street(town, tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "town.toml").write_text(PAPER, encoding="utf-8")
    other = Run.create(tmp_path / "other", replace(town.experiment, maps=(str(tmp_path / "there" / "town.toml"),)))
    assert len(world_of([str(town.path), str(other.path)], tell=_silent).maps) == 1


def _spoiled(run, **change):
    path = run.path / "maps.json"
    (kept,) = json.loads(path.read_text())
    path.write_text(json.dumps([{**kept, **change}]))


def test_an_edited_map_is_refused(town, capsys):
    _spoiled(town, text=OTHER)
    name = read_map("paper").hash
    message = f"maps.json: the map town.toml was edited (its hash is not {name}); copy it again"
    with pytest.raises(KeptMapsError) as caught:
        world_of([str(town.path)])
    assert message in str(caught.value)
    assert main(["train", "--resume", str(town.path)]) == 2
    assert message in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize("content", [b"", b"{}", b"[1]", b"\xff", b"[" * 20_000, b'[{"name": "a"}]'], ids=range(6))
def test_damaged_maps_are_named(town, content):
    (town.path / "maps.json").write_bytes(content)
    with pytest.raises(KeptMapsError, match=r"maps.json: damaged"):
        town.maps(_silent)


def test_other_maps_than_those_of_the_configuration_are_refused(town):
    _spoiled(town, name="city.toml")
    with pytest.raises(KeptMapsError, match=r"names .*town.toml, but no such map is kept here"):
        town.maps(_silent)


def test_an_older_folder_without_maps_is_read_by_path_with_a_warning(town, tmp_path, capsys):
    (town.path / "maps.json").unlink()
    assert world_of([str(town.path)]).maps[0].text == PAPER
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert err.startswith(f"warning: {town.path}: keeps no maps, as it is of an older version; ")
    (tmp_path / "town.toml").unlink()
    with pytest.raises(MapError, match="cannot be read"):
        world_of([str(town.path)])
