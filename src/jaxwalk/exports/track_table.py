"""Trajectories of an evaluation's episodes, as a table in a file."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.evaluation import episodes_at_once, play
from jaxwalk.evaluation.batches import Progress
from jaxwalk.formats.areas import areas_of
from jaxwalk.formats.layouts import RULES
from jaxwalk.formats.track_file import write_tracks
from jaxwalk.formats.tracks import Tracks, tracks_of
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.maps import as_network
from jaxwalk.scenarios import Source
from jaxwalk.sim.environment import Street


class SeveralMapsError(ValueError):
    """The street has several maps, but a file of trajectories has one."""


def record_tracks(
    street: Street, policies: Roles[Policy], source: Source, path: Path, *,
    about: dict[str, Any], progress: Progress | None = None,
) -> None:  # fmt: skip
    """Play all scenarios of a source, exactly as an evaluation does, and write their trajectories.

    Args:
        street: the world, with one map.
        policies: who plays each role.
        source: the scenarios.
        path: the Parquet file.
        about: what the file's metadata says beside the rules.
        progress: called after every batch with the episodes played so far, and all.

    Raises:
        SeveralMapsError: the street has several maps.
    """
    if len(street.maps) != 1:
        raise SeveralMapsError("the trajectories of a file need one map; choose it with --map")
    ground = areas_of(as_network(street.maps[0]))
    recordings = _recorded(street, policies, source, progress)
    rules = {name: getattr(street.config, name) for name in RULES}
    write_tracks(path, recordings, about={**rules, **about}, areas=ground)


def _recorded(street: Street, policies: Roles[Policy], source: Source, progress: Progress | None) -> Iterator[Tracks]:
    """Yield the episodes, one after the other; they are played a batch at a time."""
    episodes, batch = len(source), episodes_at_once(street, policies)
    for first in range(0, episodes, batch):
        numbers = (first + np.arange(batch)) % episodes
        scenarios, keys = source.take(numbers)
        trajectory = play(street, policies, scenarios, keys, numbers=numbers)
        asked = min(batch, episodes - first)
        yield from islice(tracks_of(trajectory), asked)
        if progress is not None:
            progress(first + asked, episodes)
