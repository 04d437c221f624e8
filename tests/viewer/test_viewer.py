from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from jaxwalk.maps import load_network
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.viewer import EpisodeFigure, ViewerError, animation, picture
from jaxwalk.viewer.episode_figure import FAINTEST, PALE, PARKED
from viewer.sight import with_sight

FRAMES, EPISODES, PEOPLE = 21, 2, 2


@pytest.fixture(scope="module")
def network():
    return load_network("paper")


@pytest.fixture
def trajectory():
    """A car to the east at 8 m/s; in episode 1 it hits pedestrian 0, who jaywalks from frame 5 on."""
    time = np.arange(FRAMES)[:, None] * 0.1
    frame, person = (FRAMES, EPISODES), (FRAMES, EPISODES, PEOPLE)
    ped_x = np.broadcast_to([26.0, 48.0], person).copy()
    ped_y = np.stack([np.broadcast_to(51.0 + 1.5 * time, frame), np.full(frame, 51.0)], axis=-1)
    on_roadway = ped_y > 52
    return Trajectory(
        dt=0.1, scenario=np.arange(2), length=np.array([20, 18]), goal=np.array([True, False]),
        collision=np.array([False, True]), touched=np.array([[False, False], [True, False]]),
        goal_x=np.full(2, 26.0), goal_y=np.full(2, 54.0), car_x=np.broadcast_to(10 + 8 * time, frame),
        car_y=np.full(frame, 54.0), car_cos=np.ones(frame), car_sin=np.zeros(frame), car_speed=np.full(frame, 8.0),
        car_acceleration=np.zeros(frame), jaywalking_tendency=np.array([[0.0, 1.0]] * 2), ped_x=ped_x, ped_y=ped_y,
        ped_vx=np.zeros(person), ped_vy=np.full(person, 1.5), on_roadway=on_roadway,
        on_crosswalk=np.zeros(person, bool), crossing=np.broadcast_to([JAYWALK, CROSSWALK], person),
        decisions=np.ones(person, int), at_kerb=np.zeros(person, bool), going=np.ones(person, bool),
        enters_roadway=np.zeros(person, bool), predicted_miss=np.full(person, 10.0),
    )  # fmt: skip


def colours(path):
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), int)


def has(image, colour, tolerance=6):
    return bool((np.abs(image - colour).max(axis=-1) <= tolerance).any())


def test_a_picture_shows_everything(trajectory, network, tmp_path):
    path = tmp_path / "end.png"
    picture(EpisodeFigure(trajectory, 1, network, width=500), path)
    image = colours(path)
    assert image.shape == (490, 500, 3)
    for colour in ((0x9A, 0x9E, 0xA5), (0xB5, 0xD3, 0xA2), (0x1F, 0x5F, 0xD0), (0xD8, 0x1E, 0x2C), (0xFF, 0xD4, 0x00)):
        assert has(image, colour)
    assert [entry.name for entry in tmp_path.iterdir()] == ["end.png"]


def test_frames_differ_and_the_last_one_is_the_default(trajectory, network, tmp_path):
    names = {None: "default.png", 18: "18.png", 3: "3.png"}
    for frame, name in names.items():
        picture(EpisodeFigure(trajectory, 1, network, width=240), tmp_path / name, frame=frame)
    default, last, early = (colours(tmp_path / name) for name in names.values())
    assert (default == last).all()
    assert (default != early).any()


def test_texts_and_jaywalks(trajectory, network):
    drawn = EpisodeFigure(trajectory, 1, network, width=240)
    assert drawn.jaywalks == [(0, 6, 18)]
    drawn.show(5)
    assert drawn.title.get_text().split() == ["0.5", "s", "8.0", "m/s"]
    assert not drawn.crash.get_visible()
    assert len(drawn.yellow.get_segments()) == 0
    drawn.show(18)
    assert drawn.title.get_text().endswith("collision")
    assert drawn.crash.get_visible()
    assert len(drawn.yellow.get_segments()) == 1
    np.testing.assert_allclose(drawn.car.get_xy().mean(axis=0), [10 + 1.8 * 8, 54], atol=0.5)


def test_who_is_not_perceived_is_pale_and_a_ring_is_where_it_was_last_seen(trajectory, network):
    slow = replace(trajectory, dt=0.4)  # so that 3 s are over within the episode
    drawn = EpisodeFigure(with_sight(slow, {0: [(2, 20)], 1: [(0, 12)]}), 1, network, width=300)
    drawn.show(1)
    assert drawn.people.get_facecolor()[:, 3].tolist() == [1, PALE]
    assert drawn.people.get_linestyles()[0] != drawn.people.get_linestyles()[1]
    assert len(drawn.last_seen.get_offsets()) == 0, "the second one was never seen"
    drawn.show(3)
    assert drawn.people.get_facecolor()[:, 3].tolist() == [PALE, PALE]
    np.testing.assert_allclose(drawn.last_seen.get_offsets(), [[26.0, 51.0 + 1.5 * 0.1]])
    assert drawn.last_seen.get_edgecolor()[0, 3] == pytest.approx(1 - 0.8 / 3)
    drawn.show(8)
    assert drawn.last_seen.get_edgecolor()[0, 3] == FAINTEST
    drawn.show(9)
    assert len(drawn.last_seen.get_offsets()) == 0, "3.2 s ago"


def test_parked_vehicles_are_drawn(trajectory, network, tmp_path):
    boxes = np.array([[30, 70, 1, 0, 20, 10], [np.nan] * 6])
    there = replace(trajectory, parked=np.stack([boxes, boxes]))
    dark = tuple(bytes.fromhex(PARKED[1:]))
    for recorded, parked in ((trajectory, False), (there, True)):
        drawn = EpisodeFigure(recorded, 1, network, width=300)
        drawn.legend.set_visible(False)
        picture(drawn, tmp_path / "parked.png")
        assert has(colours(tmp_path / "parked.png"), dark) == parked


def test_the_legend_names_what_the_world_has(trajectory, network):
    def names(recorded):
        return [text.get_text() for text in EpisodeFigure(recorded, 1, network).legend.get_texts()]

    usual = names(trajectory)
    assert len(usual) == 5
    parked = replace(trajectory, parked=np.full((2, 1, 6), np.nan))
    assert names(with_sight(parked, {})) == [*usual, "parked vehicle", "not perceived by the car", "last seen, 3 s"]


@pytest.mark.parametrize(("width", "height"), [(120, 120), (300, 60), (60, 300)])
def test_a_legend_has_a_place_of_its_own(trajectory, network, width, height):
    """That of a wide map lay over the numbers of its axis."""
    drawn = EpisodeFigure(trajectory, 1, replace(network, size=(width, height)))
    (legend,) = (place.get_window_extent() for place in drawn.figure.legends)
    axes = drawn.axes.get_tightbbox()
    assert 0 <= legend.y0 < legend.y1 <= axes.y0
    assert axes.y1 <= drawn.figure.bbox.height
    assert drawn.figure.bbox.height < 500 or height >= width


@pytest.mark.parametrize("name", ["film.gif", "FILM.GIF"])
def test_an_animation_has_a_frame_for_every_fifth_step(trajectory, network, tmp_path, name):
    animation(EpisodeFigure(trajectory, 0, network, width=150), tmp_path / name, every=5, speed=2.0)
    with Image.open(tmp_path / name) as film:
        assert film.format == "GIF"
        assert film.n_frames >= 5  # 0, 5, 10, 15 and the end, which stays for 1.5 s (equal frames may be merged)
        assert film.info["duration"] == 250
    assert [entry.name for entry in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(("write", "name"), [(picture, "a.png"), (animation, "a.gif")])
def test_a_failed_drawing_leaves_the_old_file_alone(trajectory, network, tmp_path, monkeypatch, write, name):
    path = tmp_path / name
    path.write_text("old")

    def fail(*_, **options):
        raise OSError("disk full")

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", fail)
    monkeypatch.setattr("PIL.Image.Image.save", fail)
    with pytest.raises(OSError, match="disk full"):
        write(EpisodeFigure(trajectory, 0, network), path)
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    ("write", "episode", "name", "options", "complaint"),
    [
        (picture, 0, "a.gif", {}, "must end in .png or .svg or .pdf"),
        (animation, 0, "a.png", {}, "must end in .gif or .mp4"),
        (picture, 2, "a.png", {}, "no episode 2: the trajectory has 2"),
        (picture, 0, "a.png", {"frame": 21}, "no frame 21: the episode has frames 0 to 20"),
        (picture, 0, "no/such/a.png", {}, "does not exist"),
        (animation, 0, "a.gif", {"speed": 0.0}, "speed must be above 0"),
        (animation, 0, "a.gif", {"every": 0}, "every at least 1"),
    ],
)
def test_what_cannot_be_drawn_is_refused(trajectory, network, tmp_path, write, episode, name, options, complaint):
    with pytest.raises(ViewerError, match=complaint):
        write(EpisodeFigure(trajectory, episode, network), tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_a_film_is_made_of_sizes_that_the_encoder_takes(trajectory, network, tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    animation(EpisodeFigure(trajectory, 0, network, width=151), tmp_path / "a.mp4", every=5, speed=2.0)  # odd: refused
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "a.mp4"))
    assert frames >= 5 and seconds > 1


def test_mp4_without_its_encoder_says_what_to_install(trajectory, network, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ViewerError, match="pip install"):
        animation(EpisodeFigure(trajectory, 0, network), tmp_path / "a.mp4")
    assert not list(tmp_path.iterdir())
