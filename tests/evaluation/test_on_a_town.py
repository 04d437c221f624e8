"""A generated street in the place of a map: ghosts, counterfactuals, the oracle, tracks and pages work there too."""

from __future__ import annotations

import json

import numpy as np
import pytest
import shapely

from jaxwalk import Street
from jaxwalk.cli import main
from jaxwalk.evaluation import counterfactuals, evaluate, play, walk_ghosts, with_jaywalk_multiplier
from jaxwalk.evaluation.hits import find_hits
from jaxwalk.exports.drawn_episode import draw_episode
from jaxwalk.exports.replays import recording
from jaxwalk.exports.scenario_files import export_scenario
from jaxwalk.exports.track_table import record_tracks
from jaxwalk.formats.areas import parse_areas
from jaxwalk.maps import as_network
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo, Oracle, RouteFollower
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.sim_config import SimConfig

TOWN = "test-2000000003"
"""Two junctions, bent roads, an island, parking strips, buildings; crossings with and without stripes."""
BATCH, FRAMES = 16, 130
BLIND = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}


@pytest.fixture(scope="module")
def town():
    return Street.create([TOWN], SimConfig(contact="footprint"))


@pytest.fixture(scope="module")
def network(town):
    return as_network(town.maps[0])


@pytest.fixture(scope="module")
def played(town):
    scenarios, keys = Drawn(town, 0).take(np.arange(BATCH))
    return play(town, BLIND, scenarios, keys)


def surely_and_perhaps_on(surface, x, y, *, near=0.15):
    """Kerbs of bends are chords for people."""
    sure, perhaps = surface.buffer(-near), surface.buffer(near)
    shapely.prepare([sure, perhaps])
    return shapely.contains_xy(sure, x, y), shapely.contains_xy(perhaps, x, y)


def test_people_and_cars_are_where_they_may_be(played, network):
    steps = np.arange(len(played.ped_x))[:, None] <= played.length
    sure, perhaps = surely_and_perhaps_on(network.surface("roadway"), played.ped_x, played.ped_y)
    on = played.on_roadway
    assert on[steps].any() and (played.crossing[steps] == JAYWALK).any() and (played.crossing[steps] == CROSSWALK).any()
    assert on[steps][sure[steps]].all() and not on[steps][~perhaps[steps]].any()
    _, on_foot = surely_and_perhaps_on(network.surface("sidewalk", "island", "crosswalk"), played.ped_x, played.ped_y)
    assert (on_foot | (played.crossing == JAYWALK))[steps].all()
    roadway = network.surface("roadway").buffer(0.05)
    assert shapely.contains_xy(roadway, played.car_x[steps], played.car_y[steps]).all()
    assert played.goal.mean() > 0.5


def test_ghosts_walk_where_people_do_and_are_others(town, played, network):
    scenarios, keys = Drawn(town, 0).take(np.arange(BATCH))
    ghosts = walk_ghosts(town, scenarios, keys, frames=FRAMES)
    ground = network.surface("sidewalk", "island", "crosswalk", "roadway").buffer(0.1)
    assert shapely.contains_xy(ground, ghosts.ped_x, ghosts.ped_y).all()
    assert (ghosts.ped_x[0] != played.ped_x[0]).any(axis=1).all()
    walked = np.hypot(np.diff(ghosts.ped_x, axis=0), np.diff(ghosts.ped_y, axis=0))
    assert 0.05 < np.median(walked) < 0.2


@pytest.mark.usefixtures("scenario_library")
def test_files_of_an_episode(town, played, network, tmp_path):
    source = Drawn(town, 0, BATCH)
    draw_episode(town, BLIND, source, 3, tmp_path / "end.png")
    assert export_scenario(town, BLIND, source, 3, tmp_path / "scenario", name="a town") < 1e-5
    record_tracks(town, BLIND, source, tmp_path / "t.parquet", about={})
    import pyarrow.parquet as pq

    table = pq.read_table(tmp_path / "t.parquet")
    assert table.num_rows == (13 * (played.length + 1)).sum()
    (areas,) = [json.loads(x) for x in table.schema.metadata.values() if b"FeatureCollection" in x]
    ground = parse_areas(areas, "the file")
    assert ground.roadway.symmetric_difference(network.surface("roadway")).area < 1e-3
    assert {one["properties"]["kind"] for one in areas["features"]} == {area.kind for area in network.areas}


@pytest.mark.long
def test_a_page_has_the_maps_of_its_episodes_only(town, network):
    two = Street.create([town.maps[0], "paper"], town.config)
    maps = np.asarray(Drawn(two, 0).take(np.arange(8))[0].map)
    numbers = np.flatnonzero(maps == 0)[:2].tolist()
    document = recording(two, {"blind": BLIND["driver"]}, {"all": AlwaysGo()}, {"all": numbers}, Drawn(two, 0))
    (drawn,) = document["maps"]
    assert (drawn["width"], drawn["height"]) == network.size
    assert [entry["map"] for entry in document["episodes"]] == [0, 0]


@pytest.mark.long
def test_the_oracle_arrives_where_the_blind_driver_collides(town):
    often = with_jaywalk_multiplier(town, 1.0)
    source = Drawn(often, 1, 4 * BATCH)
    blind, oracle = (
        evaluate(often, {"driver": driver, "pedestrian": AlwaysGo()}, source, batch=BATCH)[OUTCOMES]
        for driver in (RouteFollower(), Oracle())
    )
    assert blind.collision.mean() > 0.1
    assert oracle.goal.mean() >= 0.96
    assert oracle.collision.sum() < blind.collision.sum() / 4


@pytest.mark.long
def test_collisions_are_replayed_and_somebody_could_have_avoided_them(town):
    often = with_jaywalk_multiplier(town, 1.0)
    source = Drawn(often, 1, 4 * BATCH)
    hits = find_hits(evaluate(often, BLIND, source, batch=BATCH)).first(6)
    found = counterfactuals(often, BLIND, source, hits)
    assert len(found.scenario) == 6 and found.moving.any()
    assert found.wait[found.wait_applies & (found.notice > 0.5)].all(), "who waits isn't touched"
    assert found.planner_from_start.mean() > 0.6


@pytest.mark.long
def test_a_report_on_two_towns(tmp_path, capsys):
    command = "report route-follower --pedestrians always-go --map test:2 --episodes 40 --incidents 2"
    assert main([*command.split(), "--out", str(tmp_path / "mine")]) == 0
    capsys.readouterr()
    text = (tmp_path / "mine" / "report.html").read_text(encoding="utf-8")
    assert "test-2000000000" in text and '"surfaces":{"building":' in text


@pytest.mark.long
def test_an_evaluation_on_two_towns_is_made_again(tmp_path, capsys):
    command = "evaluate --driver route-follower --map test:2 --episodes 40"
    assert main([*command.split(), "--out", str(tmp_path / "mine")]) == 0
    file = tmp_path / "mine" / "results.json"
    maps = json.loads(file.read_text())["street"]["maps"]
    assert [(one["name"], sorted(one)) for one in maps] == [
        (name, ["hash", "name"]) for name in ("test-2000000000", "test-2000000001")
    ]
    capsys.readouterr()
    assert main(["evaluate", "--again", str(file)]) == 0
    assert ": equal" in capsys.readouterr().out
