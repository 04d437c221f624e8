"""Generated streets by name, in the place of maps: the same ones everywhere, and documents name them without a text."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from jaxwalk.maps import MapError, MapText, each_map, load_map, read_map, reference, text_hash, text_of
from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.generated import SPLITS
from jaxwalk.maps.generated.check_town import DISTANCES
from jaxwalk.maps.load import build_map
from jaxwalk.maps.network_file import network_text, parse_network
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.folder import Run

ONE = "test-2000000001"


def test_a_name_is_that_of_the_street_of_its_number():
    found = read_map(ONE)
    street = SPLITS["test"].street(2_000_000_001)
    assert street is not None
    assert (found.name, found.text) == (ONE, network_text(street.network))
    assert tuple(map(float, (load_map(ONE).width, load_map(ONE).height))) == pytest.approx(street.network.size)


@pytest.mark.parametrize("split", SPLITS)
def test_what_was_checked_when_it_was_made_has_no_faults_when_it_is_read(split):
    """So a street's text isn't checked again."""
    (name,) = each_map([f"{split}:1"])
    found = parse_network(read_map(name).text, name)
    assert network_faults(found, **DISTANCES) == []


def test_a_text_that_only_has_the_name_of_a_generated_street_is_checked():
    edited = json.loads(read_map(ONE).text)
    edited["routes"] = []
    with pytest.raises(MapError, match="routes: none"):
        build_map(json.dumps(edited), ONE, **DISTANCES)


def test_a_name_of_several_stands_for_the_first_that_are_not_refused():
    assert each_map(["paper", "test:2", ONE]) == ("paper", "test-2000000000", "test-2000000001", ONE)


def test_numbers_that_are_refused_are_left_out(monkeypatch):
    later = {"training": replace(SPLITS["training"], numbers=range(71, 80))}
    monkeypatch.setattr("jaxwalk.maps.generated.named_streets.SPLITS", later)
    assert each_map(["training:2"]) == ("training-71", "training-73")


WRONG = {
    "test:0": r"must lie in \[1, 1,000\], not 0",
    "test:1001": r"must lie in \[1, 1,000\], not 1,001",
    "test-17": "the numbers of test are 2000000000 to 2000999999",
    "training-72": "this number gives no street .roads meet beyond their junctions.: choose another one",
    "moon:20": "SPLIT:COUNT or SPLIT-NUMBER, where SPLIT is one of training, validation, test, unseen-ranges, arterial",
}


@pytest.mark.parametrize("name, message", WRONG.items(), ids=WRONG)
def test_what_gives_no_street_is_refused(name, message):
    with pytest.raises(MapError, match=message):
        [read_map(one) for one in each_map([name])]


def test_one_map_is_not_several():
    with pytest.raises(MapError, match="stands for several streets"):
        read_map("test:2")


def test_documents_name_a_street_without_its_text():
    named = reference(read_map(ONE))
    assert named == replace(read_map(ONE), text=None)
    assert text_of(named) == read_map(ONE)
    own = MapText.of(ONE, "{}")
    assert reference(own) == own, "its text is another one: it stays"
    for name in (ONE, "training-72"):
        with pytest.raises(MapError, match="this jaxwalk has no map of hash"):
            text_of(MapText(name, text_hash("another version's")))


def test_a_document_with_an_edited_text_is_refused():
    with pytest.raises(MapError, match=r"its text was edited \(the hash is not .*\): copy it again"):
        text_of(MapText("town.json", text_hash("{}"), text="{ }"))


def test_a_folder_stands_for_the_streets_in_it(tmp_path):
    with pytest.raises(MapError, match=r"the folder has 0 streets \(\.json\); it must have 1 to 1,000"):
        each_map([tmp_path])
    for name in ("b.json", "a.json", "report.json", "a.report.json", "notes.txt"):
        (tmp_path / name).write_text("{}", encoding="utf-8")
    assert each_map([tmp_path, "paper"]) == (str(tmp_path / "a.json"), str(tmp_path / "b.json"), "paper")


def test_a_run_folder_names_and_keeps_each_street(tmp_path):
    run = Run.create(tmp_path / "run", replace(RECIPES["fast"], maps=("paper", "test:2")))
    names = ("paper", "test-2000000000", "test-2000000001")
    again = Run.open(run.path)
    assert again.experiment.maps == names
    assert again.maps(pytest.fail) == tuple(map(read_map, names))
