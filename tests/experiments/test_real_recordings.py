"""Recordings in the layout of DUT, made by hand, and what is known of them."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from formats.scene import car, person, recording
from jaxwalk.experiments.real_recordings import MEASURED, describe, distances, in_windows, watch_clips
from jaxwalk.formats.areas import Areas, parse_areas
from jaxwalk.formats.clip_grounds import read_clip_grounds
from jaxwalk.formats.recordings import measure_tracks
from jaxwalk.formats.tracks import TracksError
from jaxwalk.metrics.path_meetings import PATH_MEETINGS
from jaxwalk.sim.sim_config import SimConfig

ROOT = Path(__file__).parents[2]
RATE = 10.0
GROUND = """
frame_rate = 10.0
roadway = [[-50, -4], [50, -4], [50, 4], [-50, 4]]
crosswalk = [[-2, -4], [2, -4], [2, 4], [-2, 4]]
[clips]
a = { turn = 0, scale = 1, move = [0, 0] }
b = { turn = 90, scale = 2, move = [100, 10] }
"""


def clip(folder: Path, name: str, people: list[np.ndarray], speed: float = 5.0) -> None:
    """Write a clip of 8 s: a car along y = 0 that is at x = -20 at first, and people with a place for each frame."""
    t = np.arange(81) / RATE
    rows = [
        f"{i},{frame},ped,{x},{y},{vx},{vy}" for i, way in enumerate(people) for frame, (x, y, vx, vy) in enumerate(way)
    ]
    (folder / f"{name}_traj_ped_filtered.csv").write_text(
        "\n".join(["id,frame,label,x_est,y_est,vx_est,vy_est", *rows]) + "\n"
    )
    cars = [f"0,{frame},veh,{-20 + speed * now},0,0,{speed}" for frame, now in enumerate(t)]
    (folder / f"{name}_traj_veh_filtered.csv").write_text(
        "\n".join(["id,frame,label,x_est,y_est,psi_est,vel_est", *cars]) + "\n"
    )


def way(begins: float, stands: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Return 8 s of somebody who goes up at 1 m/s from a place at x = 0, and stands still in between."""
    t = np.arange(81) / RATE
    still = (t > stands[0]) & (t <= stands[1])
    y = begins + np.cumsum(np.where(still, 0.0, 1 / RATE)) - 1 / RATE
    return np.stack([0 * t, y, 0 * t, np.where(still, 0.0, 1.0)], axis=1)


@pytest.fixture
def grounds(tmp_path):
    (tmp_path / "ground.toml").write_text(GROUND)
    return read_clip_grounds(tmp_path / "ground.toml")


def test_a_gap_by_hand(tmp_path, grounds):
    """The body reaches the car's path at y = -1.15: at 0.9 s from -2. The car's front is then 13.25 m before x = 0."""
    clip(tmp_path, "a", [way(-2.0)])
    found = watch_clips(tmp_path, grounds, ["a"]).rows[PATH_MEETINGS]
    assert found.accepted == pytest.approx([13.25 / 5], abs=0.11), "to within a frame"
    assert found.offered == pytest.approx([20 / 5], abs=0.11), "within 1.5 m of the path at once, the car 20 m before"
    assert found.approach_seen.tolist() == [False]
    assert found.crossing_speed == pytest.approx([1.0])
    assert found.waited.tolist() == [False]
    # off the path from y = 1.15 on, at 3.2 s; the front covers the place at 3.5 s
    assert found.pet == pytest.approx([0.4], abs=0.11)


def test_nobody_has_accepted_a_gap_unseen(tmp_path, grounds):
    """Two are on the car's path when first seen, one of them later; the third is 1.85 m before it, on the roadway."""
    later = way(-2.0)
    later[:11] = np.nan
    clip(tmp_path, "a", [way(-1.0), later, way(-3.0)], speed=4.0)
    text = (tmp_path / "a_traj_ped_filtered.csv").read_text()
    seen = "".join(line for line in text.splitlines(keepends=True) if "nan" not in line)
    (tmp_path / "a_traj_ped_filtered.csv").write_text(seen)
    found = watch_clips(tmp_path, grounds, ["a"]).rows[PATH_MEETINGS]
    assert (found.pet > 0).all()
    assert np.isnan(found.accepted).tolist() == [True, True, False]
    assert found.approach_seen.tolist() == [False, False, True]


def test_who_stops_waits_and_lets_the_car_go_first(tmp_path, grounds):
    clip(tmp_path, "a", [way(-5.0, stands=(1.5, 4.0)), way(-6.5, stands=(1.5, 1.8))])
    found = watch_clips(tmp_path, grounds, ["a"]).rows[PATH_MEETINGS]
    assert found.waited.tolist() == [True, False], "0.3 s is no stop"
    assert (found.pet < 0).all()
    assert np.isnan(found.accepted).all()
    assert np.isnan(found.offered).all(), "the car has passed when they are 1.5 m before its path"


def test_a_turned_camera_sees_the_same_ground(grounds):
    """A quarter turn from x towards y, twice as large: (2, 4) is at (-8, 4) then, and at (92, 14) when moved."""
    inside = [list(grounds.areas("b").locate(np.array([x]), np.array([14.0]))) for x in (92.1, 91.9)]
    assert [[bool(one[0]) for one in each] for each in inside] == [[True, False], [False, False]]
    assert bool(grounds.areas("b").locate(np.array([100.0]), np.array([10.0]))[1][0])


def test_intervals_and_distances_are_over_clips(tmp_path, grounds):
    both = replace(grounds, clips={"a": grounds.clips["a"], "c": grounds.clips["a"]})
    clip(tmp_path, "a", [way(-2.0)])
    clip(tmp_path, "c", [way(-5.0, stands=(1.5, 4.0))])
    real = watch_clips(tmp_path, both, ["a", "c"])
    numbers = describe(real)
    assert numbers["recordings"] == 2
    waited = numbers["meetings"]["waited"]
    assert (waited["value"], waited["low"], waited["high"], waited["count"]) == (0.5, 0.0, 1.0, 2)
    assert numbers["speeds"][0]["crosswalk"]["value"] == pytest.approx(5.0)
    away = distances(real, {"nobody waits": watch_clips(tmp_path, both, ["a"]), "same": real})["waited"]
    assert away["nobody waits"][0] == pytest.approx(0.5)
    assert set(np.round(away["nobody waits"], 9)) == {0.0, 0.5, 1.0}
    assert away["same"][0] == 0


def street(*crosswalks: float) -> Areas:
    """Return a road along y = 0, 8 m wide, with crosswalks 4 m wide at places x."""

    def feature(kind: str, left: float, right: float) -> dict:
        corners = [[left, -4], [right, -4], [right, 4], [left, 4], [left, -4]]
        geometry = {"type": "Polygon", "coordinates": [corners]}
        return {"type": "Feature", "properties": {"kind": kind}, "geometry": geometry}

    features = [feature("roadway", -50, 50), *(feature("crosswalk", x - 2, x + 2) for x in crosswalks)]
    return parse_areas({"type": "FeatureCollection", "features": features}, "a street")


def test_the_window_cuts_and_forgets():
    tracks = recording(car(0, 4, -20, 0, 10.0), person(0, 4, 0, 5), person(0, 4, 0, 15))
    (seen,) = in_windows(replace(tracks, known={"speed": tracks.t}), street(0.0))
    assert seen.known == {}
    assert set(seen.id) == {0, 1}
    assert np.abs(seen.x).max() <= 10
    with pytest.raises(TracksError, match="no crosswalk"):
        next(in_windows(tracks, street()))


def test_everybody_counts_at_the_nearest_of_two_crosswalks():
    """They are at x = 0 and 12, so both windows show what is between 2 and 10. Person 2 walks there along the kerb."""
    tracks = recording(
        car(0, 8, -20, 0, 5.0), person(0, 8, 5, -6, 0, 1.5), person(0, 8, 2, 5, 0.5), person(0, 8, 7, 6, 0, -1.5)
    )
    both = [*in_windows(tracks, street(0.0, 12.0))]
    assert [sorted(set(seen.id)) for seen in both] == [[0, 1, 2], [0, 3]]
    met = [[*measure_tracks(seen, areas=street(0.0, 12.0), config=SimConfig(), metrics=MEASURED)] for seen in both]
    assert [sum(len(rows[PATH_MEETINGS].pet) for rows in each) for each in met] == [1, 1]


def test_a_window_may_show_nobody():
    near, far = in_windows(recording(car(0, 4, -4, 0, 2.0)), street(0.0, 30.0))
    found = [[*measure_tracks(seen, areas=None, config=SimConfig(), metrics=MEASURED)] for seen in (near, far)]
    assert [len(rows) for rows in found] == [1, 0]


def test_a_second_crossing_may_count_at_another_crosswalk():
    """Up at x = 1 to the kerb, along it, and down at x = 11: from the first kerb on, all of it counts there."""
    up, along, down = person(0, 4, 1, -5, 0, 2.5), person(4.04, 8, 1, 5, 2.5), person(8.04, 12, 11, 5, 0, -2.5)
    tracks = recording(up, along, down, ids=(1, 1, 1))
    first, second = in_windows(tracks, street(0.0, 12.0))
    assert (first.t.max(), first.y.max()) == pytest.approx((3.56, 3.9), abs=0.05)
    assert second.t.min() == pytest.approx(4.4, abs=0.05), "not before x = 2, where the second window begins"
    assert second.t.max() == 12.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("scale = 2", "scale = 0"), "clips.b.scale"),
        (("[50, 4], [-50, 4]", "[-50, 4], [50, 4]"), "crosses itself"),
        (("frame_rate = 10.0", "rate = 10.0"), "frame_rate|rate"),
        (("[clips]", "[clips"), "not TOML"),
    ],
)
def test_a_wrong_ground_is_refused(tmp_path, change, message):
    (tmp_path / "ground.toml").write_text(GROUND.replace(*change))
    with pytest.raises(TracksError, match=message):
        read_clip_grounds(tmp_path / "ground.toml")


def test_the_study_measures_a_folder(tmp_path):
    clip(tmp_path, "a", [way(-2.0), way(-5.0, stands=(1.5, 4.0))])
    (tmp_path / "ground.toml").write_text(GROUND.replace("b = { turn = 90, scale = 2, move = [100, 10] }", ""))
    program = [sys.executable, str(ROOT / "docs" / "real_recordings_study.py"), str(tmp_path)]
    options = ["--ground", str(tmp_path / "ground.toml"), "--out", str(tmp_path / "out"), "--pedestrians"]
    done = subprocess.run([*program, *options], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    document = json.loads((tmp_path / "out" / "results.json").read_text())
    assert document["real"]["meetings"]["waited"]["value"] == 0.5
    assert "| meetings | 2 |" in (tmp_path / "out" / "results.md").read_text()
    lost = subprocess.run([*program[:2], str(tmp_path / "no"), *options], capture_output=True, text=True, check=False)
    assert lost.returncode == 2
    assert "no such file" in lost.stderr


def test_our_ground_of_dut_is_one_place():
    """In every clip the crosswalk is about 13 m long and 6 m wide, and lies on the roadway."""
    grounds = read_clip_grounds(ROOT / "docs" / "dut_ground.toml")
    assert len(grounds.clips) == 17
    for name in grounds.clips:
        areas = grounds.areas(name)
        assert areas.crosswalk.area == pytest.approx(13.0 * 6.3, rel=0.05)
        assert areas.crosswalk.within(areas.roadway.buffer(0.2))
