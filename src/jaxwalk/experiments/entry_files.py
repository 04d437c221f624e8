"""The files of a leaderboard's entry: whether all are in its folder, and the seed that follows from them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

from jaxwalk.evaluation import Results
from jaxwalk.policies import shipped_policy
from jaxwalk.policies.mixture_names import mixture_of
from jaxwalk.policies.policy_names import RULES, is_class
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.runs.lock import LOCK

CHECKED = "checked.json"
BYTECODE = "__pycache__"
"""Folder of what Python compiles; a check neither reads nor writes it."""
SEEDS = 2**31
"""Number of seeds."""


class SubmissionError(ValueError):
    """A folder is no entry. The message names the folder, what is missing and what to do, in one line."""


def fresh_seed(folder: Path, results: Results) -> int:
    """Return the seed of a checker's scenarios, which isn't that of the author's ``results``.

    It follows from the names and contents of all files of the entry, `CHECKED` apart, so nobody can choose it, and a
    change of any file changes it. Raises SubmissionError for a link.
    """
    digest = hashlib.sha256()
    for file in _files(folder):
        name = file.relative_to(folder).as_posix().encode()
        for part in (name, file.read_bytes()):
            digest.update(hashlib.sha256(part).digest())  # hashes of one length: where a part ends can't be shifted
    seed = int.from_bytes(digest.digest()[:4], "big") % SEEDS
    return seed if seed != results.scenarios.seed else (seed + 1) % SEEDS


def _files(folder: Path) -> Iterator[Path]:
    """Yield the files of an entry in the order of their names. Raise SubmissionError for a link."""
    for path in sorted(folder.rglob("*"), key=lambda path: path.relative_to(folder).as_posix()):
        inside = path.relative_to(folder)
        if path.is_symlink():
            raise SubmissionError(f"{path}: is a link; put the file itself into the entry's folder")
        if path.is_file() and BYTECODE not in inside.parts and str(inside) not in (CHECKED, LOCK):
            yield path


def missing_file(folder: Path, role: str, name: str) -> str | None:
    """Return the first part of a driver or population that is missing in a folder; None if none is.

    A mixture has several parts; a driver behind a shield is one. A rule, or a policy that comes with jaxwalk, is
    never missing.

    Args:
        folder: the folder of an entry.
        role: ``driver`` or ``pedestrian``.
        name: the name of the driver or population in the results.

    Raises:
        MixtureError: the name is that of a mixture which can't be understood.
    """
    parts = list(mixture_of(role, name)) or [unshielded(role, name)[0]]
    own = [part for part in parts if part not in RULES[role] and shipped_policy(role, part) is None]
    return next((part for part in own if not _inside(folder, part)), None)


def _inside(folder: Path, name: str) -> bool:
    """Return whether a name stands for a file, or a folder, inside a folder."""
    home = name.rpartition(":")[0] if is_class(name) else name
    local = Path(*home.split("."))
    modules = (local.with_suffix(".py"), local / "__init__.py") if is_class(name) and not home.endswith(".py") else ()
    places = [folder / path for path in (modules or (Path(home),))]
    return any(place.exists() and place.resolve().is_relative_to(folder.resolve()) for place in places)
