"""Foreign trajectories: several cars, people who come and go, another frame rate, no decisions."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from formats.scene import STREET, car, person, recording
from jaxwalk.formats.areas import parse_areas, read_areas
from jaxwalk.formats.measured import measure_all
from jaxwalk.formats.recordings import _crossing_numbers, cars_in_view, trajectory_of
from jaxwalk.formats.tracks import TracksError
from jaxwalk.metrics import CROSSINGS, ENCOUNTERS, OUTCOMES, SURROGATES
from jaxwalk.metrics.braking import NEVER, ONSET, UNSEEN
from jaxwalk.sim.sim_config import SimConfig

CONFIG = SimConfig()
GROUND = parse_areas(STREET, "street")


def _rows(tracks, areas=GROUND):
    return measure_all([(tracks, areas)], config=CONFIG).rows


def test_surrogates_by_hand():
    """Standing on the road 10 m ahead of where a car at 10 m/s goes out of view: TTC (10 - 2.5) / 10 s."""
    rows = _rows(recording(car(0, 4, 0, 0, 10.0), person(0, 4, 50, 0)))
    assert rows[ENCOUNTERS].start.tolist() == [30], "within 20 m from 3 s on"
    assert rows[SURROGATES].ttc == pytest.approx([0.75], abs=1e-6)
    assert rows[SURROGATES].drac == pytest.approx([10**2 / (2 * 7.5)], rel=1e-5)
    assert rows[SURROGATES].exposed_time == pytest.approx([0.8], abs=1e-6), "below 1.5 s from 17.5 m on: 8 frames"
    assert rows[ENCOUNTERS].min_distance == pytest.approx([10.0], abs=1e-5)
    assert rows[ENCOUNTERS].braking.tolist() == [UNSEEN]
    assert np.isnan(rows[ENCOUNTERS].braking_time).all()


def test_who_crosses_where():
    """Up from y = -5 at 1 m/s: on the road from 1 s on. One on the crosswalk, one 1 m beside it."""
    rows = _rows(recording(car(0, 9, 0, 2, 5.0), person(0, 9, 100, -5, vy=1.0), person(0, 9, 103, -5, vy=1.0)))
    assert rows[CROSSINGS].type.tolist() == [1, 2]
    assert rows[CROSSINGS].enter.tolist() == [11, 11], "a kerb is no roadway"
    assert rows[CROSSINGS].last.tolist() == [89, 89]
    assert rows[CROSSINGS].entry_seen.tolist() == [True, True]


def test_every_car_has_its_episode_and_its_people():
    early, late = person(0, 5, 60, 1), person(20, 26, 60, 1)
    tracks = recording(car(0, 6, 0, 0, 10.0), car(20, 25, 10, 0, 10.0), early, late)
    rows = _rows(tracks)
    assert rows[OUTCOMES].steps.tolist() == [60, 50]
    assert rows[ENCOUNTERS].episode.tolist() == [0, 1]
    assert rows[ENCOUNTERS].ped.tolist() == [0, 0]
    assert [len(view.people) for view in cars_in_view(tracks, CONFIG)] == [1, 1]


def test_who_is_out_of_view_is_nowhere():
    tracks = recording(car(0, 6, 0, 0, 10.0), person(2, 4, 58, 1))
    trajectory = trajectory_of(next(cars_in_view(tracks, CONFIG)), areas=GROUND, config=CONFIG)
    seen = np.arange(61)[:, None]
    seen = (seen >= 20) & (seen <= 40)
    assert np.array_equal(~np.isnan(trajectory.ped_x[:, 0]), seen)
    assert np.array_equal(trajectory.on_roadway[:, 0], seen)
    says_so = replace(tracks, known=dict.fromkeys(("on_roadway", "on_crosswalk"), tracks.type == "pedestrian"))
    trajectory = trajectory_of(next(cars_in_view(says_so, CONFIG)), areas=None, config=CONFIG)
    assert np.array_equal(trajectory.on_crosswalk[:, 0], seen), "on a crosswalk in every row, and nowhere without one"
    rows = _rows(tracks)
    assert rows[ENCOUNTERS].min_distance == pytest.approx([np.hypot(18, 1)], abs=1e-4), (
        "at 4 s, though the car drives up to it"
    )


def test_who_appears_on_the_roadway_was_not_seen_to_enter_it():
    enters, appears = person(0, 6, 60, -5, vy=1.0), person(2, 6, 70, 0)
    rows = _rows(recording(car(0, 6, 0, 0, 10.0), enters, appears))
    assert rows[ENCOUNTERS].braking.tolist() == [NEVER, UNSEEN]
    assert rows[CROSSINGS].entry_seen.tolist() == [True, False]


def test_after_a_gap_it_is_somebody_else():
    tracks = recording(car(0, 6, 0, 0, 10.0), person(0, 1, 90, 1), person(2.5, 6, 90, 1), ids=(0, 1, 1))
    assert [len(view.people) for view in cars_in_view(tracks, CONFIG)] == [2]
    short = recording(car(0, 6, 0, 0, 10.0), person(0, 1, 90, 1), person(1.5, 6, 90, 1), ids=(0, 1, 1))
    assert [len(view.people) for view in cars_in_view(short, CONFIG)] == [1], "half a second is bridged"


def test_parked_cars_are_left_out():
    tracks = recording(car(0, 60, 55, 6), car(0, 6, 0, 0, 10.0), person(0, 6, 60, 1))
    assert _rows(tracks)[OUTCOMES].steps.tolist() == [60]
    with pytest.raises(TracksError, match="no car moves"):
        _rows(recording(car(0, 60, 55, 6), person(0, 6, 60, 1)))


def test_a_car_that_backs_up_moves_backwards():
    rows = _rows(recording(car(0, 3, 80, 0, -5.0, heading=0.0), person(0, 3, 60, 0)))
    assert rows[SURROGATES].ttc == pytest.approx([(5 - 2.5) / 5], abs=1e-6)


def test_y_may_point_down():
    """As in the pictures of DUT and CITR: the same scene in a mirror, on a street that is its own mirror image."""
    tracks = recording(car(0, 9, 0, 2, 8.0, heading=0.02), person(0, 9, 62, -5, vy=1.2), person(0, 9, 101, 5, vy=-1.0))
    mirrored = replace(tracks, y=-tracks.y, vy=-tracks.vy, heading=-tracks.heading)
    rows, other = _rows(tracks), _rows(mirrored)
    assert rows[CROSSINGS].type.tolist() == other[CROSSINGS].type.tolist() == [2, 1]
    for name in ("ttc", "pet", "t2", "drac", "exposed_time"):
        values = getattr(rows[SURROGATES], name)
        assert np.allclose(values, getattr(other[SURROGATES], name), equal_nan=True), name
    assert np.isfinite(rows[SURROGATES].pet).any()


def test_braking_is_read_from_the_speed():
    """10 m/s for 2 s, then 4 m/s2 less: the first frame with less speed is at 2.1 s, its command came at 2.0 s."""
    rate = 50
    tracks = recording(car(0, 4, 0, 0, 10.0), person(0, 4, 40, -5, vy=1.0), rate=rate)
    mine = tracks.type == "car"
    late = np.maximum(tracks.t - 2, 0)
    slower = replace(
        tracks, vx=np.where(mine, 10 - 4 * late, tracks.vx), x=np.where(mine, tracks.x - 2 * late**2, tracks.x)
    )
    rows = _rows(slower)
    assert rows[ENCOUNTERS].enter.tolist() == [11]
    assert rows[ENCOUNTERS].braking.tolist() == [ONSET]
    assert rows[ENCOUNTERS].braking_time == pytest.approx([0.9])


@pytest.mark.parametrize("rate", [8.0, 23.976, 25.0, 29.97])
def test_any_frame_rate_is_resampled_to_the_same(rate):
    walks = person(0, 4, 90, -5, vy=1.0)
    rows = _rows(recording(car(0, 4, 0, 0, 10.0), person(0, 4, 50, 0), walks, rate=rate))
    assert rows.dt == 0.1
    assert rows[OUTCOMES].steps.tolist() == [40]
    assert rows[SURROGATES].ttc == pytest.approx([0.75], abs=1e-6)
    assert rows[CROSSINGS].enter.tolist() == [0, 11]


def test_what_cannot_be_told_is_left_out():
    tracks = recording(car(0, 6, 0, 0, 10.0), person(0, 6, 100, -5, vy=1.0), person(0, 6, 60, 9))
    found = measure_all([(tracks, GROUND)], config=CONFIG).as_dict()
    assert found["encounters"].keys() == found["surrogates"].keys() == {"crosswalk", "jaywalk"}
    assert "collided" not in found["encounters"]["jaywalk"]
    assert not {"outcomes", "attribution", "jaywalk_rate", "waiting"} & found.keys()
    blind = measure_all([(tracks, None)], config=CONFIG).as_dict()
    assert blind["encounters"].keys() == blind["surrogates"].keys() == {"anybody"}
    assert blind["encounters"]["anybody"]["count"] == 1, "who stands beside the road is met too"
    assert "braking" not in blind["encounters"]["anybody"]
    assert "speed_differential" not in blind
    assert blind["kilometres"] == pytest.approx(0.06)
    assert blind["hours"] == pytest.approx(6 / 3600)
    json.dumps([found, blind], allow_nan=False)


def test_endings_count_where_nothing_says_where_people_walk():
    """One car in two reaches its goal; where those were walking whom cars touch isn't known."""
    tracks = recording(car(0, 2, 0, 0, 10.0), person(0, 2, 60, 9))
    known = {"touched": np.zeros(len(tracks.t), bool)}
    both = [
        (replace(tracks, episode=n, known=known | {"ending": np.full(len(tracks.t), ending)}), None)
        for n, ending in enumerate(("goal", "timeout"))
    ]
    counted = []
    found = measure_all(both, config=CONFIG, progress=counted.append).as_dict()
    assert counted == [1, 2]
    assert found["outcomes"]["goal"]["value"] == 0.5
    assert not {"crosswalk", "jaywalk", "sidewalk"} & found["outcomes"].keys()


def test_nobody_to_meet():
    found = measure_all([(recording(car(0, 6, 0, 0, 10.0)), GROUND)], config=CONFIG).as_dict()
    assert found["surrogates"]["jaywalk"]["count"] == 0


@pytest.mark.parametrize("words", [["none", "jaywalk"], ["none", "zebra" * 40]])
def test_words_of_crossing(words):
    """Text of any length is looked at as it is, not copied into an array with room for the longest in every row."""
    column = np.array(words, object)
    if "jaywalk" in words:
        assert _crossing_numbers(column).tolist() == [0, 2]
        return
    with pytest.raises(TracksError, match=r"column crossing: \[\.\.\.\]; it must be one of none, crosswalk, jaywalk"):
        _crossing_numbers(column)


def test_two_rows_of_one_moment():
    tracks = recording(car(0, 6, 0, 0, 10.0), person(0, 6, 60, 1), person(3, 8, 60, 1), ids=(0, 1, 1))
    with pytest.raises(TracksError, match="road user 1 has two rows at 3 s"):
        _rows(tracks)


WRONG = {
    "no JSON": ("{", "not GeoJSON"),
    "brackets": ("[" * 20_000, "not GeoJSON"),
    "no list": ('{"type": "FeatureCollection", "features": 3}', "its features must be a list"),
    "a kind that is a list": (
        json.dumps(STREET).replace('"crosswalk"', '["crosswalk"]'),
        "feature 1: kind must be one of roadway, sidewalk, crosswalk, island, parking, building, not .'crosswalk'",
    ),
    "no collection": ("[]", "must be a GeoJSON FeatureCollection"),
    "no roadway": ('{"type": "FeatureCollection", "features": []}', "no feature with"),
    "another kind": (json.dumps(STREET).replace("crosswalk", "zebra"), "feature 1: kind must be one of"),
    "no polygon": (
        json.dumps({**STREET, "features": [
            {"type": "Feature", "properties": {"kind": "roadway"}, "geometry": {"type": "Point", "coordinates": [0, 0]}}
        ]}),
        "feature 0: must be a polygon",
    ),
    "no geometry": ('{"type": "FeatureCollection", "features": [{}]}', "feature 0: needs properties.kind"),
}  # fmt: skip


@pytest.mark.parametrize("text, message", WRONG.values(), ids=WRONG)
def test_areas_that_cannot_be_used(tmp_path, text, message):
    (tmp_path / "areas.geojson").write_text(text)
    with pytest.raises(TracksError, match=message):
        read_areas(tmp_path / "areas.geojson")
