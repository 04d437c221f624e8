"""Trajectories of an evaluation's episodes, as a table in a file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import jax
import numpy as np

from jaxwalk.evaluation import BATCH, play
from jaxwalk.formats.areas import areas_of
from jaxwalk.formats.layouts import RULES
from jaxwalk.formats.track_file import write_tracks
from jaxwalk.formats.tracks import Tracks, tracks_of
from jaxwalk.interfaces import Policy
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street


class SeveralMapsError(ValueError):
    """The street has several maps, but a file of trajectories has one."""


def record_tracks(
    street: Street,
    driver: Policy,
    pedestrians: Policy,
    path: Path,
    *,
    episodes: int,
    seed: int,
    about: dict[str, Any],
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Play scenarios 0 .. ``episodes`` - 1 of a seed, exactly as an evaluation does, and write their trajectories.

    Args:
        street: the world, with one map.
        driver: decides for the car.
        pedestrians: decides for all people.
        path: the Parquet file.
        episodes: how many.
        seed: which set of scenarios.
        about: what else the file's metadata are to say.
        progress: called after every batch with the episodes played so far and ``episodes``.

    Raises:
        SeveralMapsError: the street has several maps.
    """
    if street.world.maps.width.shape[0] != 1:
        raise SeveralMapsError("the trajectories of a file need one map; choose it with --map")
    ground = areas_of(jax.device_get(jax.tree.map(lambda x: x[0], street.world.maps)))
    recordings = _recorded(street, driver, pedestrians, episodes, seed, progress)
    rules = {name: getattr(street.config, name) for name in RULES}
    write_tracks(path, recordings, about={**rules, **about, "seed": seed}, areas=ground)


def _recorded(
    street: Street,
    driver: Policy,
    pedestrians: Policy,
    episodes: int,
    seed: int,
    progress: Callable[[int, int], None] | None,
) -> Iterator[Tracks]:
    """Yield the episodes one after the other; they are played in batches."""
    policies, source = {"driver": driver, "pedestrian": pedestrians}, Drawn(street, seed, episodes)
    for first in range(0, episodes, BATCH):
        numbers = (first + np.arange(BATCH)) % episodes
        scenarios, keys = source.take(numbers)
        trajectory = play(street, policies, scenarios, keys, numbers=numbers)
        asked = min(BATCH, episodes - first)
        yield from islice(tracks_of(trajectory), asked)
        if progress is not None:
            progress(first + asked, episodes)
