"""Pictures and animations as files. A failure leaves no partial file and doesn't change an old one."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path

import numpy as np
from PIL import Image

from jaxwalk.viewer.episode_figure import EpisodeFigure, ViewerError
from jaxwalk.writing import whole

PICTURES = (".png", ".svg", ".pdf")
"""File name endings of pictures."""
ANIMATIONS = (".gif", ".mp4")
"""File name endings of animations."""
STILL = 1.5
"""Time for which an animation stays on its last frame [s]."""


def picture(figure: EpisodeFigure, path: str | Path, *, frame: int | None = None) -> None:
    """Write one frame of an episode as a picture.

    Args:
        figure: the episode.
        path: the file, ending in .png, .svg or .pdf.
        frame: the frame to show, from 0; None shows the last one.

    Raises:
        ViewerError: there is no such frame or folder, or the file has another ending.
    """
    path = _checked(path, PICTURES, "picture")
    frame = figure.last if frame is None else frame
    if not 0 <= frame <= figure.last:
        raise ViewerError(f"there is no frame {frame}: the episode has frames 0 to {figure.last}")
    figure.show(frame)
    with whole(path) as unfinished:
        figure.figure.savefig(unfinished)


def animation(figure: EpisodeFigure, path: str | Path, *, speed: float = 2.0, every: int = 2) -> None:
    """Write an episode as an animation.

    Args:
        figure: the episode.
        path: the file, ending in .gif, or in .mp4 if imageio-ffmpeg is installed.
        speed: simulated seconds shown in one second.
        every: simulation steps between two images.

    Raises:
        ViewerError: there is no such folder, the file has another ending, ``speed`` or ``every`` is impossible, or
            imageio-ffmpeg is missing for an MP4.
    """
    path = _checked(path, ANIMATIONS, "animation")
    if not speed > 0 or every < 1:
        raise ViewerError(f"speed must be above 0 and every at least 1, not {speed} and {every}")
    rate = speed / (figure.trajectory.dt * every)
    frames = [*range(0, figure.last, every), *[figure.last] * math.ceil(STILL * rate)]
    images = (figure.pixels(frame) for frame in frames)
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    with whole(path) as unfinished:
        write(unfinished, images, rate)


def _checked(path: str | Path, kinds: tuple[str, ...], what: str) -> Path:
    """Return the path. Raises ViewerError if its ending isn't one of ``kinds`` or its folder is missing."""
    path = Path(path)
    if path.suffix.lower() not in kinds:
        raise ViewerError(f"{path}: the name of the {what} must end in {' or '.join(kinds)}")
    if not path.parent.is_dir():
        raise ViewerError(f"{path}: the folder {path.parent} does not exist; make it first")
    return path


def _write_gif(path: Path, images: Iterable[np.ndarray], rate: float) -> None:
    """Write a GIF. All images share the colours of the last one, so that nothing flickers."""
    frames = [Image.fromarray(image) for image in images]
    palette = frames[-1].quantize(colors=255)
    first, *others = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    first.save(path, save_all=True, append_images=others, duration=round(1000 / rate), loop=0)


def _write_mp4(path: Path, images: Iterable[np.ndarray], rate: float) -> None:
    try:
        encoder = import_module("imageio_ffmpeg")
    except ImportError:
        raise ViewerError("MP4 needs imageio-ffmpeg: pip install 'jaxwalk[video]', or name a .gif file") from None
    # Without this it forks a process, which may hang beside JAX's threads.
    os.environ.setdefault("IMAGEIO_FFMPEG_NO_PREVENT_SIGINT", "1")
    writer = None
    for image in images:
        image = image[: len(image) // 2 * 2, : image.shape[1] // 2 * 2]  # the encoder needs even sizes
        if writer is None:
            writer = encoder.write_frames(str(path), image.shape[1::-1], fps=rate, macro_block_size=1)
            writer.send(None)
        writer.send(np.ascontiguousarray(image))
    if writer is not None:
        writer.close()
