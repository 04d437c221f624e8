"""The scenarios that a training mixes in: archives that the run folder keeps, so that it can be copied and resumed."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from jaxwalk.recipes import Experiment
from jaxwalk.writing import write_whole

if TYPE_CHECKING:
    from jaxwalk.scenarios.archived import Archived
    from jaxwalk.sim.environment import Street  # JAX comes with it, so functions import it when they need it

HASH_DIGITS = 16


class KeptArchiveError(ValueError):
    """An archive can't be mixed into a training. The message names it and says what to do, in one line."""


def keep_archives(folder: Path, contents: Sequence[bytes]) -> None:
    """Write the files of archives into a run folder."""
    for path, content in zip(kept_archives(folder, len(contents)), contents, strict=True):
        write_whole(path, content)


def kept_archives(folder: Path, count: int) -> list[Path]:
    """Return the paths of the archives that a run folder keeps."""
    return [folder / f"archive-{number}.safetensors" for number in range(count)]


def archive_hashes(paths: Sequence[Path]) -> list[str]:
    """Return the hash of each file; an empty text where one is missing."""
    return [hashlib.sha256(path.read_bytes()).hexdigest()[:HASH_DIGITS] if path.is_file() else "" for path in paths]


def with_archives(street: Street, experiment: Experiment, paths: Sequence[str | Path]) -> Street:
    """Return the street of a training that mixes archives into its episodes, each where its number of people plays.

    Raises:
        ArchiveError: a file can't be read.
        KeptArchiveError: an archive is of another street or world, of a number of people that the training doesn't
            have, or people are absent in it.
    """
    import jax
    import jax.numpy as jnp

    from jaxwalk.scenarios.archive_file import read_archive
    from jaxwalk.sim.kept_points import KeptPoints

    points: dict[int, list[np.ndarray]] = {}
    for path in paths:
        archived = read_archive(path)
        _check(path, archived, street, experiment)
        points.setdefault(archived.street.config.pedestrians, []).append(archived.points)
    share = jnp.float32(experiment.archive_share)
    kept = {people: KeptPoints(jax.device_put(np.concatenate(of)), share) for people, of in points.items()}
    return replace(street, kept=kept)


def _check(path: str | Path, archived: Archived, street: Street, experiment: Experiment) -> None:
    """Raise KeptArchiveError unless the archive's scenarios are ones that the training could draw."""
    theirs, ours = ([found.hash for found in of.maps] for of in (archived.street, street))
    if theirs != ours:
        raise KeptArchiveError(
            f"{path}: its scenarios are of other maps than the training's, {', '.join(experiment.maps):.200}; search "
            "with --map on these"
        )
    people = archived.street.config.pedestrians
    crowds = experiment.crowds or (street.config.pedestrians,)
    if people not in crowds:
        raise KeptArchiveError(
            f"{path}: its scenarios have {people} people, the training's have {' or '.join(map(str, crowds))}; search "
            "with --people"
        )
    rules = asdict(replace(street.config, pedestrians=people))
    differ = [name for name, value in asdict(archived.street.config).items() if value != rules[name]]
    if differ:
        raise KeptArchiveError(
            f"{path}: its scenarios are of another world than the training's ({', '.join(differ)} differ); search with "
            "--world, or train in the archive's"
        )
    if not archived.present.all():
        raise KeptArchiveError(
            f"{path}: people are absent in its scenarios, as in minimised ones; name the folder of the search"
        )
