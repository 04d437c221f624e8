"""The files of a leaderboard's entry: whether all are in its folder, a copy of them, and the seed that follows."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from jaxwalk.evaluation import Results
from jaxwalk.policies import shipped_policy
from jaxwalk.policies.mixture_names import mixture_of
from jaxwalk.policies.policy_names import RULES, is_class
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.runs.lock import LOCK

CHECKED = "checked.json"
BYTECODE = "__pycache__"
"""Name of folders for what Python compiles: no files of an entry."""
SEEDS = 2**31
"""Number of seeds."""


class SubmissionError(ValueError):
    """A folder is no entry. The message names the folder, what is missing and what to do, in one line."""


def fresh_seed(folder: Path, results: Results, salt: str | None = None) -> int:
    """Return the seed of a checker's scenarios, which isn't that of the author's ``results``.

    It follows from the names and contents of all files of the entry (`files_of`), and a change of any file changes it.
    So it isn't secret: an author can change a file until the seed suits. With a long random ``salt`` that the author
    doesn't know, the author can't know the seed either.

    Raises:
        SubmissionError: there is a link in the folder.
    """
    digest = hashlib.sha256()
    for file in files_of(folder):
        name = file.relative_to(folder).as_posix().encode()
        for part in (name, file.read_bytes()):
            digest.update(hashlib.sha256(part).digest())  # hashes of one length: where a part ends can't be shifted
    if salt is not None:
        digest.update(hashlib.sha256(os.fsencode(salt)).digest())
    seed = int.from_bytes(digest.digest()[:4], "big") % SEEDS
    return seed if seed != results.scenarios.seed else (seed + 1) % SEEDS


@contextmanager
def copy_of(folder: Path) -> Iterator[Path]:
    """Yield a folder with a copy of an entry's files (`files_of`) and of nothing else; it is removed afterwards.

    Raises:
        SubmissionError: there is a link in the folder.
    """
    with TemporaryDirectory() as place:
        copy = Path(place).resolve()
        for file in files_of(folder):
            there = copy / file.relative_to(folder)
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, there)
        yield copy


def files_of(folder: Path) -> Iterator[Path]:
    """Yield the files of an entry in the order of their names.

    All files in the folder and in its folders are the entry's but what a check writes (`CHECKED`, `LOCK`) and what is
    in a folder called `BYTECODE`.

    Raises:
        SubmissionError: there is a link in the folder.
    """
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
        SubmissionError: there is a link in the folder.
    """
    parts = list(mixture_of(role, name)) or [unshielded(role, name)[0]]
    own = [part for part in parts if part not in RULES[role] and shipped_policy(role, part) is None]
    return next((part for part in own if not _inside(folder, part)), None)


def _inside(folder: Path, name: str) -> bool:
    """Return whether a name, seen from the folder, stands for a file of the entry or a folder of such files."""
    home = name.rpartition(":")[0] if is_class(name) else name
    local = Path(*home.split("."))
    modules = (local.with_suffix(".py"), local / "__init__.py") if is_class(name) and not home.endswith(".py") else ()
    files = [file.relative_to(folder) for file in files_of(folder)]
    return any(place == file or place in file.parents for place in modules or (Path(home),) for file in files)
