"""What a page replays is what happened, to the half centimetre."""

from __future__ import annotations

import base64
import dataclasses
import json
import zlib

import numpy as np
import pytest

from jaxwalk.maps import load_network
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.perceived import KEPT
from jaxwalk.sim.walking_paths import Paths
from jaxwalk.viewer.record import GOING, JAYWALKS, ON_ROADWAY, UNPERCEIVED, make_records
from jaxwalk.viewer.replay import as_script, document, entries, part, replay_page
from metrics.scenes import Scene, Walk, trajectory
from viewer.sight import with_sight

PEOPLE = [
    Walk(30.0, -4.0, vy=1.0, crossings=[(12, 40, JAYWALK)], waits=[1], tau=0.9),
    Walk(40.0, 4.0, vx=0.5, crossings=[(0, 30, CROSSWALK)], tau=0.25),
]
BRAKES = {k: -3.0 for k in range(15, 25)}
SCENES = (Scene(50, PEOPLE, goal=True, acceleration=BRAKES), Scene(30, PEOPLE, touched=[0]), Scene(20, PEOPLE))


@pytest.fixture(scope="module")
def recorded():
    return trajectory(*SCENES, scenario=[7, 9, 11])


def unpacked(text):
    return json.loads(zlib.decompress(base64.b64decode(text)))


def test_places_and_speeds_come_back(recorded):
    for e, text in enumerate(make_records(recorded)):
        record, frames = unpacked(text), slice(recorded.length[e] + 1)
        for name in ("x", "y", "speed", "acceleration"):
            found = np.cumsum(record["car"][name]) / 100
            np.testing.assert_allclose(found, getattr(recorded, f"car_{name}")[frames, e], atol=0.005)
        for ped, person in enumerate(record["people"]):
            np.testing.assert_allclose(np.cumsum(person["x"]) / 100, recorded.ped_x[frames, e, ped], atol=0.005)
            np.testing.assert_allclose(np.cumsum(person["y"]) / 100, recorded.ped_y[frames, e, ped], atol=0.005)
        assert record["tendency"] == [0.9, 0.25]


def test_a_heading_never_jumps(recorded):
    angles = np.linspace(3.0, 3.3, recorded.car_cos.shape[0])[:, None]  # beyond 180 degrees
    turned = dataclasses.replace(
        recorded, car_cos=np.cos(angles) + 0 * recorded.car_x, car_sin=np.sin(angles) + 0 * recorded.car_x
    )
    record = unpacked(make_records(turned)[0])
    np.testing.assert_allclose(np.cumsum(record["car"]["heading"]) / 1000, angles[:, 0], atol=0.001)


def test_states_say_who_goes_and_how_they_cross(recorded):
    state = np.cumsum(unpacked(make_records(recorded)[0])["people"][0]["state"])
    assert state[1] & GOING == 0
    assert state[2] & GOING
    assert state[20] & (ON_ROADWAY | JAYWALKS) == ON_ROADWAY | JAYWALKS
    assert state[45] & ON_ROADWAY == 0


def test_events_are_marked_in_the_order_of_time(recorded):
    goal, hit, late = (unpacked(text)["events"] for text in make_records(recorded))
    assert goal == [
        {"frame": 12, "what": "jaywalk", "ped": 0},
        {"frame": 14, "what": "brake", "ped": 0},
        {"frame": 50, "what": "goal", "ped": None},
    ]
    assert hit[-1] == {"frame": 30, "what": "collision", "ped": 0}
    assert late[-1] == {"frame": 20, "what": "timeout", "ped": None}
    assert unpacked(make_records(recorded)[1])["touched"] == [0]


def test_plans_end_at_the_goal_that_is_walked_to(recorded):
    x = np.array([30.0, 30.0, 30.0, 35.0, 35.0])
    y = np.array([-4.0, -2.0, 4.0, 4.0, 40.0])
    shape = (2, 3)
    paths = Paths(
        x=np.broadcast_to(x[:, None, None], (5, *shape)),
        y=np.broadcast_to(y[:, None, None], (5, *shape)),
        jaywalk=np.broadcast_to(np.array([0, 1, 0, 0], bool)[:, None, None], (4, *shape)),
        arrivals=np.broadcast_to(np.array([0, 0, 0, 1])[:, None, None], (4, *shape)),
    )
    plan = unpacked(make_records(recorded, paths)[0])["paths"][0]  # it walks 5 m
    assert np.cumsum(plan["x"]).tolist() == [3000, 3000, 3000, 3500]
    assert plan["jaywalks"] == [1]
    assert plan["goals"] == [3]
    assert unpacked(make_records(recorded)[0]).get("paths") is None


def test_no_name_can_end_the_script(recorded, tmp_path):
    name = "</script><script>alert(1)</script>"
    found = entries(recorded, make_records(recorded), [0, 0, 0], driver=name, pedestrians="x", multiplier=0.25)
    made = document(found, [load_network("paper")], dt=0.1)
    assert json.loads(as_script(made)) == made
    replay_page(made, tmp_path / "page.html", title=name)
    text = (tmp_path / "page.html").read_text()
    assert text.count("</script>") == 2
    assert "alert(1)</script>" not in text
    assert [file.name for file in tmp_path.iterdir()] == ["page.html"]


def test_a_page_entry_says_how_it_ended(recorded):
    found = entries(recorded, make_records(recorded), [0, 0, 0], driver="a", pedestrians="b", multiplier=0.25)
    said = [(entry["scenario"], entry["ending"], entry["steps"]) for entry in found]
    assert said == [(7, "goal", 50), (9, "collision", 30), (11, "timeout", 20)]


def test_a_world_without_perception_has_the_records_it_had(recorded):
    """To the byte: no field more, and no bit more in anybody's state."""
    for text in make_records(recorded):
        record = unpacked(text)
        assert list(record) == ["goal", "touched", "tendency", "car", "people", "events", "route"]
        for person in record["people"]:
            assert list(person) == ["x", "y", "state"]
            assert max(np.cumsum(person["state"])) < UNPERCEIVED


def test_who_is_perceived_is_a_bit_and_each_loss_a_place(recorded):
    hidden = {0: [(10, 20), (25, 30)], 1: [(0, 5)]}
    record = unpacked(make_records(with_sight(recorded, hidden))[0])
    for ped, times in hidden.items():
        bits = np.cumsum(record["people"][ped]["state"]) & UNPERCEIVED > 0
        assert np.flatnonzero(bits).tolist() == [k for begin, end in times for k in range(begin, end)]
    crosses, walks = record["people"]
    assert np.cumsum(crosses["lost"]["x"]).tolist() == [3000, 3000]
    seen = recorded.ped_y[[9, 24], 0, 0]
    np.testing.assert_allclose(np.cumsum(crosses["lost"]["y"]) / 100, seen, atol=0.005)
    assert walks["lost"] == {"x": [], "y": []}, "whom it has never seen it can't lose"
    assert record["delay"] == 0


def test_a_delay_counts_in_steps(recorded):
    late = with_sight(recorded, {0: [(10, 20)]}, delay=4)
    record = unpacked(make_records(late)[0])
    assert record["delay"] == 4
    assert np.cumsum(record["people"][0]["lost"]["y"])[0] / 100 == pytest.approx(recorded.ped_y[5, 0, 0], abs=0.005)


def test_parked_vehicles_are_stored_once_each(recorded):
    free = np.full(6, np.nan)
    boxes = np.array([[20, 5, 1, 0, 2.2, 0.9], free, [26.004, 5, 0, 1, 2.2, 0.7]])
    some = dataclasses.replace(recorded, parked=np.stack([boxes, boxes[[1, 1, 1]], boxes]))
    first, second, _ = (unpacked(text)["parked"] for text in make_records(some))
    assert first == {"x": [2000, 600], "y": [500, 0], "heading": [0, 1571], "length": [440, 0], "width": [180, -40]}
    assert second == {"x": [], "y": [], "heading": [], "length": [], "width": []}


def test_the_page_remembers_people_as_long_as_the_car_does():
    assert f"const KEPT = {KEPT:g};" in part("record.js")
