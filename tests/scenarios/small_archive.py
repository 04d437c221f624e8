"""An archive of a few ordinary scenarios, as if a search had found them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from jaxwalk.scenarios import Archived
from jaxwalk.scenarios.archive_file import write_archive
from jaxwalk.search.cube import ordinary
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import dimensions

COUNT = 3


def write_small_archive(path: Path, street: Street, *, present: bool = True, seed: int = 1) -> Archived:
    """Write some scenarios of a street into a file."""
    points = ordinary(np.random.default_rng(seed), COUNT, dimensions(street.world))
    there = np.full((COUNT, street.config.pedestrians), present)
    kept = Archived(street, points, there, 0, np.arange(COUNT))
    path.parent.mkdir(parents=True, exist_ok=True)
    write_archive(path, kept, {})
    return kept
