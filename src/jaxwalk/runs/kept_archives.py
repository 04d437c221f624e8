"""The scenarios that a training mixes in: archives that the run folder keeps, so that it can be copied and resumed."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING

import numpy as np

from jaxwalk.recipes import Experiment
from jaxwalk.wording import counted
from jaxwalk.writing import write_whole

if TYPE_CHECKING:
    from jaxwalk.scenarios.archived import Archived
    from jaxwalk.sim.environment import Street  # JAX comes with it, so functions import it when they need it

HASH_DIGITS = 16
"""Number of hexadecimal digits of the hash of kept scenarios."""
LONGEST = 120
"""Longest list of maps in a message [characters]."""


class KeptArchiveError(ValueError):
    """An archive can't be mixed into a training. The message names it and says what to do, in one line."""


def archive_contents(archive: str | Path) -> bytes:
    """Return the bytes of an archive. Raise ArchiveError if there is none."""
    from jaxwalk.scenarios.archive_file import archive_bytes  # takes a while, and few trainings have archives

    return archive_bytes(archive)


def keep_archives(folder: Path, contents: Sequence[bytes]) -> None:
    """Write the files of archives into a run folder."""
    for number, content in enumerate(contents):
        write_whole(_copy(folder, number), content)


def kept_archives(folder: Path, count: int) -> list[Path]:
    """Return the paths of the archives that a run folder keeps. Raise KeptArchiveError if one is missing."""
    paths = [_copy(folder, number) for number in range(count)]
    for path in paths:
        if not path.is_file():
            raise KeptArchiveError(f"{path}: missing; copy it again from where the run was made, or train anew")
    return paths


def archive_hashes(street: Street) -> list[str]:
    """Return the hash of the scenarios that are mixed in for each number of people."""
    points = [np.asarray(street.kept[people].points) for people in sorted(street.kept)]
    return [hashlib.sha256(of.tobytes()).hexdigest()[:HASH_DIGITS] for of in points]


def with_archives(street: Street, experiment: Experiment, paths: Sequence[str | Path]) -> Street:
    """Return the street of a training that mixes archives into its episodes, each where its number of people plays.

    Raises:
        ArchiveError: a file can't be read.
        KeptArchiveError: an archive is there twice, is of another street or world or of a number of people that the
            training doesn't have, or people are absent in it.
    """
    import jax

    from jaxwalk.scenarios.archive_file import read_archive
    from jaxwalk.sim.kept_points import KeptPoints

    points: dict[int, list[np.ndarray]] = {}
    for path in paths:
        archived = read_archive(path)
        _check(path, archived, street, experiment)
        same_crowd = points.setdefault(archived.street.config.pedestrians, [])
        if any(np.array_equal(archived.points, other) for other in same_crowd):
            raise KeptArchiveError(f"{path}: its scenarios are those of another archive; name it once")
        same_crowd.append(archived.points)
    share = np.float32(experiment.archive_share)
    kept = {people: KeptPoints(*jax.device_put((np.concatenate(of), share))) for people, of in points.items()}
    return replace(street, kept=kept)


def said_of_archives(street: Street, experiment: Experiment) -> list[str]:
    """Return a line for each number of people with which kept scenarios are mixed in."""
    return [
        f"{100 * experiment.archive_share:g} % of the episodes with {counted(people, 'pedestrian')} begin with one of "
        f"{counted(len(kept.points), 'kept scenario')}"
        for people, kept in sorted(street.kept.items())
    ]


def _copy(folder: Path, number: int) -> Path:
    return folder / f"archive-{number}.safetensors"


def _check(path: str | Path, archived: Archived, street: Street, experiment: Experiment) -> None:
    """Raise KeptArchiveError unless the archive's scenarios are ones that the training could draw."""
    theirs, ours = ([found.hash for found in of.maps] for of in (archived.street, street))
    if theirs != ours:
        order = " in another order" if sorted(theirs) == sorted(ours) else ""
        named, wanted = (shorten(", ".join(m.name for m in of.maps), LONGEST) for of in (archived.street, street))
        raise KeptArchiveError(
            f"{path}: its scenarios are of the maps {named}, the training's{order} are {wanted}; search with --map on "
            "the training's"
        )
    people = archived.street.config.pedestrians
    crowds = experiment.crowds or (street.config.pedestrians,)
    if people not in crowds:
        raise KeptArchiveError(
            f"{path}: its scenarios have {people} people, the training's have {' or '.join(map(str, crowds))}; search "
            "with --people"
        )
    rules = asdict(replace(street.config, pedestrians=people))
    for name, value in asdict(archived.street.config).items():
        if value != rules[name]:
            raise KeptArchiveError(
                f"{path}: its scenarios are of another world, where {name} is {value!r:.80}, not {rules[name]!r:.80} "
                "as in the training's; search in the training's world (--world, --jaywalk-multiplier)"
            )
    if not archived.present.all():
        raise KeptArchiveError(
            f"{path}: people are absent in its scenarios, as in minimised ones; name the folder of the search"
        )
