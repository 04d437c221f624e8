"""``jaxwalk tracks``, ``measure`` and ``scenario``, as a user types them."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET

import pyarrow.parquet
import pytest

from jaxwalk.cli import main


def _run(command):
    return main(command.split())


@pytest.mark.long
def test_what_tracks_writes_measure_measures_as_evaluate_does(place, capsys):
    assert _run("tracks --driver route-follower --episodes 40 --seed 3 --out tracks.parquet") == 0
    assert "40 episodes, scenarios 0 to 39 of seed 3" in capsys.readouterr().out
    assert pyarrow.parquet.read_table(place / "tracks.parquet", columns=["episode"])[
        "episode"
    ].unique().to_pylist() == [*range(40)]
    assert _run("measure tracks.parquet --json") == 0
    measured = json.loads(capsys.readouterr().out)
    assert _run("evaluate --driver route-follower --episodes 40 --seed 3 --json") == 0
    cell = json.loads(capsys.readouterr().out)["cells"][0]
    for name in ("outcomes", "attribution", "jaywalk_rate", "waiting", "contacts"):
        assert measured[name] == cell[name], name
    for found, expected in zip(measured["speed_differential"], cell["speed_differential"], strict=True):
        assert {**found, "placebo": None} == {**expected, "placebo": None}, "there are no ghosts in a file"
    assert _run("measure tracks.parquet") == 0
    shown = capsys.readouterr().out
    assert "Encounters of 40 cars" in shown and "Speed near jaywalkers" in shown and "Left out" not in shown


@pytest.mark.usefixtures("scenario_library")
def test_an_episode_for_other_simulators(place, capsys):
    assert _run("scenario --driver route-follower --scenario 3 --out there") == 0
    said = capsys.readouterr().out
    assert float(said.split("by more than ")[1].removesuffix(" mm\n")) < 50, "less than 5 cm"
    assert sorted(path.name for path in (place / "there").iterdir()) == ["commonroad.xml", "episode.xosc", "map.xodr"]
    header = ET.parse(place / "there" / "episode.xosc").find("FileHeader")
    assert header.get("description") == "jaxwalk: route-follower among always-go, scenario 3 of seed 0"


@pytest.mark.usefixtures("scenario_library")
def test_crash_tests_for_other_simulators(place, capsys):
    (place / "mine.toml").write_text(MINE)
    assert _run("scenario --tests mine.toml --out there") == 0
    assert capsys.readouterr().out == "there: 2 runs of mine, with map.xodr\n"
    names = ["crossing-20.xosc", "crossing-30.xosc", "map.xodr"]
    assert sorted(path.name for path in (place / "there").iterdir()) == names
    assert _run("scenario --tests there/crossing-20.xosc --out again") == 0
    assert capsys.readouterr().out == "again: 1 run of crossing-20, with map.xodr\n"
    texts = [(place / folder / "crossing-20.xosc").read_text() for folder in ("there", "again")]
    assert [text.count("<Vertex") for text in texts] == [2, 2]


MINE = """
name = "mine"
title = "My crash tests"
source = "me"
[[tests]]
name = "crossing"
title = "an adult crosses"
speeds = [20, 30]
meets = { x = 130.0 }
[[tests.people]]
path = [[0.0, -4.0], [0.0, 6.0]]
hit = 50.0
"""
BAD = {
    "no driver": ("tracks", "--driver is missing"),
    "unknown driver": ("tracks --driver nobody", "nobody: no driver of that name"),
    "no episodes": ("tracks --driver random --episodes 0", "--episodes must lie in [1, 10,000,000]"),
    "negative seed": ("tracks --driver random --seed -1", "--seed must lie in"),
    "another kind of file": ("tracks --driver random --out tracks.csv", "must end in .parquet"),
    "a folder": ("tracks --driver random --out folder.parquet", "is a folder"),
    "no map": ("tracks --driver random --map moon", "no such map"),
    "nothing to measure": ("measure", "FILE is missing"),
    "no such file": ("measure none.parquet", "none.parquet: no such file"),
    "unknown layout": ("measure notes.txt", "unknown layout"),
    "not the layout": ("measure 07_tracks.csv", "has no column trackId"),
    "no frame rate": ("measure a_traj_ped_filtered.csv", "does not state its frame rate"),
    "no areas": ("measure 07_tracks.csv --areas none.geojson", "none.geojson"),
    "bad areas": ("measure 07_tracks.csv --areas notes.txt", "not GeoJSON"),
    "no driver of a scenario": ("scenario", "--driver is missing"),
    "negative scenario": ("scenario --driver random --scenario -1", "--scenario must lie in"),
    "no tests": ("scenario --tests moon", "moon: no such suite of crash tests"),
    "no scenario": ("scenario --tests notes.xosc", "notes.xosc: can't be read (No such file or directory)"),
    "no such layer": ("scenario --tests r152 --layers early", "no such layer; choose from standard"),
    "a driver in tests": (
        "scenario --tests r152 --driver random",
        "--tests writes crash tests, in which nobody drives",
    ),
    "options of an episode in tests": (
        "scenario --tests r152 --pedestrians learned --scenario 3 --seed 1 --map paper --world town --people 4 "
        "--jaywalk-multiplier 1 --scenarios notes.txt",
        "the rest; leave out --pedestrians, --scenario, --seed, --scenarios, --map, --world, --people, --jaywalk-multi",
    ),
    "layers without tests": ("scenario --driver random --layers all", "--layers chooses among crash tests"),
    "scenario in a file": ("scenario --driver random --out notes.txt", "is a file"),
}
AFTER_THE_LIBRARY = ("no tests", "no scenario", "no such layer")
"""What is only found once scenariogeneration is there."""


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_used_ends_in_one_message(name, place, capsys, request):
    command, message = BAD[name]
    if name in AFTER_THE_LIBRARY:
        request.getfixturevalue("scenario_library")
    for name in ("notes.txt", "07_tracks.csv", "a_traj_ped_filtered.csv"):
        (place / name).write_text("id,x\n")
    (place / "folder.parquet").mkdir()
    before = sorted(place.iterdir())
    assert _run(command) == 2
    error = capsys.readouterr().err
    assert message in error and error.startswith("jaxwalk: ") and error.count("jaxwalk: ") == 1
    assert sorted(place.iterdir()) == before, "nothing is written"
