"""Files of the public layouts, made here: their data needs registration."""

from __future__ import annotations

import numpy as np
import pytest

from formats.scene import STREET
from jaxwalk.formats.areas import parse_areas
from jaxwalk.formats.layouts import open_tracks
from jaxwalk.formats.measured import measure_all
from jaxwalk.formats.track_file import TrackFile, write_tracks
from jaxwalk.formats.tracks import TracksError
from jaxwalk.metrics import CROSSINGS, ENCOUNTERS, OUTCOMES, SURROGATES
from jaxwalk.sim.sim_config import SimConfig

HEAD = (
    "recordingId,trackId,frame,trackLifetime,xCenter,yCenter,heading,width,length,xVelocity,yVelocity,"
    "xAcceleration,yAcceleration,lonVelocity,latVelocity,lonAcceleration,latAcceleration"
)
RATE = 25
CAR, PEDESTRIAN, BICYCLE = 0, 1, 2


def _ind(folder, *, frames=100, meta="", classes="0,car\n1,pedestrian\n2,bicycle\n"):
    """A car north at 8 m/s, a pedestrian who stands 45 m ahead of it, a bicycle: recording 7."""
    lines = [HEAD]
    for frame in range(frames):
        y = 8 * frame / RATE
        lines += [
            f"7,{CAR},{frame},{frame},100.0,{y - 45},90.0,1.9,4.6,0.0,8.0,0,0,8.0,0,0,0",
            f"7,{PEDESTRIAN},{frame},{frame},100.0,0.0,0.0,0.0,0.0,0.0,0.0,0,0,0,0,0,0",
            f"7,{BICYCLE},{frame},{frame},90.0,{y},90.0,0.0,0.0,0.0,8.0,0,0,8.0,0,0,0",
        ]
    (folder / "07_tracks.csv").write_text("\n".join(lines) + "\n")
    (folder / "07_tracksMeta.csv").write_text(
        "recordingId,trackId,initialFrame,finalFrame,numFrames,width,length,class\n"
        + "".join(
            f"7,{line.split(',')[0]},0,{frames - 1},{frames},0,0,{line.split(',')[1]}\n" for line in classes.split()
        )
    )
    (folder / "07_recordingMeta.csv").write_text(
        meta or f"recordingId,locationId,frameRate,speedLimit,orthoPxToMeter\n7,2,{RATE},13.9,0.0127\n"
    )
    return folder / "07_tracks.csv"


def test_ind(tmp_path):
    source = open_tracks(_ind(tmp_path))
    (tracks,) = source.recordings
    assert (source.areas, source.rules, tracks.episode) == (None, {}, 7)
    assert sorted(set(tracks.type.tolist())) == ["bicycle", "car", "pedestrian"]
    mine = tracks.id == CAR
    assert tracks.heading[mine] == pytest.approx(np.full(100, np.pi / 2))
    assert tracks.t[mine][-1] == pytest.approx(99 / 25)
    assert (tracks.width[mine][0], tracks.length[mine][0]) == (1.9, 4.6)
    rows = measure_all([(tracks, None)], config=SimConfig()).rows
    assert rows[OUTCOMES].scenario.tolist() == [7], "the one car; a bicycle drives no episode and is no pedestrian"
    left = 45 - 8 * 3.9  # 3.96 s are seen: the last step of 0.1 s ends at 3.9 s
    assert rows[SURROGATES].ttc == pytest.approx([(left - 4.6 / 2 - 0.25) / 8], abs=1e-5)


@pytest.mark.parametrize(
    "spoil, message",
    [
        (lambda f: (f / "07_tracksMeta.csv").unlink(), "07_tracksMeta.csv: no such file"),
        (lambda f: (f / "07_recordingMeta.csv").write_text("recordingId\n7\n"), "no column frameRate"),
        (lambda f: _ind(f, meta="recordingId,frameRate\n7,0\n"), "frameRate above 0"),
        (lambda f: _ind(f, classes="0,car\n1,pedestrian\n"), "has no track 2"),
        (lambda f: (f / "07_tracks.csv").write_text(HEAD + "\n7,0\n"), "another number of values"),
        (lambda f: (f / "07_tracks.csv").write_text(f"{HEAD}\n{','.join(['x'] * 17)}\n"), "could not convert"),
    ],
)
def test_ind_files_that_cannot_be_used(tmp_path, spoil, message):
    path = _ind(tmp_path)
    spoil(tmp_path)
    with pytest.raises(TracksError, match=message):
        open_tracks(path)


def _dut(folder):
    """A car along the road of `STREET` at 6 m/s, and a pedestrian who walks over the crosswalk at 1.2 m/s."""
    cars, people = ["id,frame,label,x_est,y_est,psi_est,vel_est"], ["id,frame,label,x_est,y_est,vx_est,vy_est"]
    for frame in range(240):
        t = frame / 23.976
        cars.append(f"0,{frame},veh,{50 + 6 * t},1.0,0.0,6.0")
        people.append(f"0,{frame},ped,100.0,{-6 + 1.2 * t},0.0,1.2")
    (folder / "intersection_01_traj_veh_filtered.csv").write_text("\n".join(cars))
    (folder / "intersection_01_traj_ped_filtered.csv").write_text("\n".join(people))
    return folder / "intersection_01_traj_ped_filtered.csv"


def test_dut(tmp_path):
    (tracks,) = open_tracks(_dut(tmp_path), frame_rate=23.976, number=4).recordings
    assert tracks.episode == 4
    assert set(zip(tracks.id.tolist(), tracks.type.tolist(), strict=True)) == {(0, "car"), (1, "pedestrian")}
    rows = measure_all([(tracks, parse_areas(STREET, "street"))], config=SimConfig()).rows
    assert rows[CROSSINGS].type.tolist() == [1]
    assert rows[CROSSINGS].enter * 0.1 == pytest.approx([2 / 1.2], abs=0.1), "from y = -6 to the kerb at -4"
    assert rows[ENCOUNTERS].entry_speed == pytest.approx([6.0])
    distance = np.hypot(50 + 6 * (t := np.arange(30, 99) * 0.1) - 100, 1.0 - (-6 + 1.2 * t)).min()
    assert rows[ENCOUNTERS].min_distance == pytest.approx([distance], abs=0.02)


def test_dut_does_not_say_its_frame_rate(tmp_path):
    path = _dut(tmp_path)
    with pytest.raises(TracksError, match=r"give it \(23.976 for DUT, 29.97 for CITR\)"):
        open_tracks(path)
    with pytest.raises(TracksError, match="frame rate must be above 0"):
        open_tracks(path, frame_rate=0.0)
    (tmp_path / "intersection_01_traj_veh_filtered.csv").unlink()
    with pytest.raises(TracksError, match="beside the others"):
        open_tracks(path, frame_rate=23.976)


def test_any_layout_can_be_kept_as_our_table(tmp_path):
    (tracks,) = open_tracks(_dut(tmp_path), frame_rate=23.976).recordings
    write_tracks(tmp_path / "dut.parquet", [tracks], about={"from": "DUT"}, areas=STREET)
    file = TrackFile(tmp_path / "dut.parquet")
    again = measure_all(((one, file.areas) for one in file.recordings()), config=SimConfig()).as_dict()
    assert again == measure_all([(tracks, parse_areas(STREET, "street"))], config=SimConfig()).as_dict()


def test_our_tables_say_by_which_rules_they_were_recorded(tmp_path):
    (tracks,) = open_tracks(_dut(tmp_path), frame_rate=23.976).recordings
    write_tracks(tmp_path / "t.parquet", [tracks], about={"dt": 0.05, "moving_speed": 0.4, "map": "paper"})
    assert open_tracks(tmp_path / "t.parquet").rules == {"dt": 0.05, "moving_speed": 0.4}


def test_a_rule_that_is_no_number_is_refused(tmp_path):
    (tracks,) = open_tracks(_dut(tmp_path), frame_rate=23.976).recordings
    write_tracks(tmp_path / "t.parquet", [tracks], about={"dt": "quick"})
    with pytest.raises(TracksError, match=r"t\.parquet: its dt must be a number, not 'quick'; write it again"):
        open_tracks(tmp_path / "t.parquet")


def test_other_files(tmp_path):
    (tmp_path / "tracks.csv").write_text("")
    with pytest.raises(TracksError, match="unknown layout"):
        open_tracks(tmp_path / "tracks.csv")
    with pytest.raises(TracksError, match="no such file"):
        open_tracks(tmp_path / "tracks.parquet")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe", "not a CSV file"),
        (b"recordingId,frameRate\n" + b"7" * 200_000 + b",25\n", "not a CSV file"),
        (b"recordingId,frameRate\nnan,25\n", "column recordingId has a value that is no number up to"),
        (b"recordingId,frameRate\n1e300,25\n", "column recordingId has a value that is no number up to"),
    ],
    ids=["bytes", "field", "nan", "huge"],
)
def test_a_damaged_file_is_named(tmp_path, content, message):
    path = _ind(tmp_path)
    (tmp_path / "07_recordingMeta.csv").write_bytes(content)
    with pytest.raises(TracksError, match=rf"07_recordingMeta\.csv: {message}"):
        open_tracks(path)


@pytest.mark.parametrize("column", ["id", "class"])
def test_a_long_value_does_not_fill_memory(tmp_path, column):
    """An array of text has room for the longest in every row."""
    path, long = _ind(tmp_path), "7" * 1001
    row = f"{long},car" if column == "id" else f"0,{long}"
    (tmp_path / "07_tracksMeta.csv").write_text(f"trackId,class\n{row}\n")
    with pytest.raises(TracksError, match=r"tracksMeta\.csv: column \w+ has a value of 1,001 characters; correct it"):
        open_tracks(path)


def test_words_take_their_own_room_only(tmp_path):
    """A class of 1,000 letters, on many rows."""
    (tracks,) = open_tracks(_ind(tmp_path, classes=f"0,car\n1,pedestrian\n2,{'x' * 1000}\n")).recordings
    assert tracks.type.nbytes < 10 * len(tracks.t)
    assert len(set(tracks.type.tolist())) == 3


def test_a_frame_rate_that_nothing_has(tmp_path):
    path = _ind(tmp_path, meta="recordingId,frameRate\n7,1e-300\n")
    with pytest.raises(TracksError, match=r"07_tracks\.csv: at 1e-300 frames per second, a time is beyond 1e\+12 s"):
        open_tracks(path)
    with pytest.raises(TracksError, match="check the frame rate"):
        open_tracks(_dut(tmp_path), frame_rate=1e-300)


def test_a_recording_that_would_fill_memory(tmp_path, monkeypatch):
    from jaxwalk.formats import recordings

    monkeypatch.setattr(recordings, "MOST_MOMENTS", 20)
    (tracks,) = open_tracks(_ind(tmp_path)).recordings
    with pytest.raises(TracksError, match=r"car 0 has 39 steps among 1 people, too many to measure at once"):
        measure_all([(tracks, None)], config=SimConfig())
