"""Pictures and animations as files, each written whole or not at all."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path

import numpy as np
from PIL import Image

from jaxwalk.maps import RoadMap
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.viewer.scene import Scene
from jaxwalk.writing import whole

PICTURES = (".png", ".svg", ".pdf")
"""What a picture can be, by the end of the file's name."""
ANIMATIONS = (".gif", ".mp4")
"""What an animation can be, by the end of the file's name."""
STILL = 1.5
"""An animation ends with this much time on its last frame [s]."""


class ViewerError(ValueError):
    """What is asked for can't be drawn; one line says why and what to do."""


def picture(
    trajectory: Trajectory,
    episode: int,
    road_map: RoadMap,
    path: str | Path,
    *,
    frame: int | None = None,
    width: int = 960,
) -> None:
    """Write one frame of an episode as a picture.

    Args:
        trajectory: recorded episodes.
        episode: which of its episodes, from 0.
        road_map: the map it was played on, as `load_map` gives it (no stack).
        path: the file, ending in .png, .svg or .pdf.
        frame: which frame, from 0; the episode's last one if left out.
        width: in pixels; the height is about the same.

    Raises:
        ViewerError: no such episode or frame, or a file of another kind.
    """
    path = _checked(path, PICTURES, "picture")
    scene = _scene(trajectory, episode, road_map, width)
    frame = scene.last if frame is None else frame
    if not 0 <= frame <= scene.last:
        raise ViewerError(f"there is no frame {frame}: the episode has frames 0 to {scene.last}")
    scene.show(frame)
    with whole(path) as unfinished:
        scene.figure.savefig(unfinished)


def animation(
    trajectory: Trajectory,
    episode: int,
    road_map: RoadMap,
    path: str | Path,
    *,
    speed: float = 2.0,
    every: int = 2,
    width: int = 640,
) -> None:
    """Write an episode as an animation.

    Args:
        trajectory: recorded episodes.
        episode: which of its episodes, from 0.
        road_map: the map it was played on, as `load_map` gives it (no stack).
        path: the file, ending in .gif, or in .mp4 where imageio-ffmpeg is installed.
        speed: how much faster than in reality things happen.
        every: an image for every so many steps.
        width: in pixels; the height is about the same.

    Raises:
        ViewerError: no such episode, a file of another kind, an impossible ``speed`` or ``every``, or an MP4 without
            imageio-ffmpeg.
    """
    path = _checked(path, ANIMATIONS, "animation")
    if not speed > 0 or every < 1:
        raise ViewerError(f"speed must be above 0 and every at least 1, not {speed} and {every}")
    scene = _scene(trajectory, episode, road_map, width)
    rate = speed / (trajectory.dt * every)
    frames = [*range(0, scene.last, every), *[scene.last] * math.ceil(STILL * rate)]
    images = (scene.pixels(frame) for frame in frames)
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    with whole(path) as unfinished:
        write(unfinished, images, rate)


def _scene(trajectory: Trajectory, episode: int, road_map: RoadMap, width: int) -> Scene:
    episodes = len(trajectory.length)
    if not 0 <= episode < episodes:
        raise ViewerError(f"there is no episode {episode}: the trajectory has {episodes}, from 0")
    if np.ndim(road_map.width):
        raise ViewerError("the map is a stack of maps: give one, as load_map does")
    return Scene(trajectory, episode, road_map, width=width)


def _checked(path: str | Path, kinds: tuple[str, ...], what: str) -> Path:
    """The path, if it can be written to."""
    path = Path(path)
    if path.suffix.lower() not in kinds:
        raise ViewerError(f"{path}: the name of the {what} must end in {' or '.join(kinds)}")
    if not path.parent.is_dir():
        raise ViewerError(f"{path}: the folder {path.parent} does not exist; make it first")
    return path


def _write_gif(path: Path, images: Iterable[np.ndarray], rate: float) -> None:
    """All images share the last one's colours, so that nothing flickers."""
    frames = [Image.fromarray(image) for image in images]
    palette = frames[-1].quantize(colors=255)
    first, *others = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    first.save(path, save_all=True, append_images=others, duration=round(1000 / rate), loop=0)


def _write_mp4(path: Path, images: Iterable[np.ndarray], rate: float) -> None:
    try:
        encoder = import_module("imageio_ffmpeg")
    except ImportError:
        raise ViewerError("MP4 needs imageio-ffmpeg: pip install 'jaxwalk[video]', or name a .gif file") from None
    # without this it forks, which may hang beside JAX's threads
    os.environ.setdefault("IMAGEIO_FFMPEG_NO_PREVENT_SIGINT", "1")
    writer = None
    for image in images:
        image = image[: len(image) // 2 * 2, : image.shape[1] // 2 * 2]  # the encoder wants even sizes
        if writer is None:
            writer = encoder.write_frames(str(path), image.shape[1::-1], fps=rate, macro_block_size=1)
            writer.send(None)
        writer.send(np.ascontiguousarray(image))
    if writer is not None:
        writer.close()
