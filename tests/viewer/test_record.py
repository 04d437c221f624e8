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
from jaxwalk.sim.walking_paths import Paths
from jaxwalk.viewer.record import GOING, JAYWALKS, ON_ROADWAY, make_records
from jaxwalk.viewer.replay import as_script, document, entries, replay_page
from metrics.scenes import Scene, Walk, trajectory

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
