"""The run folder: everything that a training writes, and everything that evaluation needs.

    config.json         the `Experiment`
    maps.json           the maps that it is trained on (`jaxwalk.runs.kept_maps`)
    archive-N.safetensors    scenarios that it mixes in (`jaxwalk.runs.kept_archives`)
    metrics.jsonl       one line for each update
    events.out.*        the same for TensorBoard
    checkpoints/        to resume from
    policy.safetensors  the trained actors, with where they come from
    watch.html, .js     the progress page, if it was asked for (`jaxwalk.runs.watch`)
    .lock               held by the process that trains

Files are written under another name and renamed when whole; lines are added to ``metrics.jsonl`` and ``events.out.*``.
"""

from __future__ import annotations

import codecs
import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError

from jaxwalk.recipes import Experiment
from jaxwalk.runs.board import Board
from jaxwalk.runs.kept_archives import archive_contents, keep_archives, kept_archives
from jaxwalk.runs.kept_maps import keep_maps, kept_maps, to_stderr
from jaxwalk.runs.lock import LOCK, held
from jaxwalk.writing import is_unfinished, naming, write_whole

if TYPE_CHECKING:
    from jaxwalk.maps import MapText

CONFIG, METRICS, CHECKPOINTS, POLICY = "config.json", "metrics.jsonl", "checkpoints", "policy.safetensors"
"""File names inside a run folder."""
HASH = "hash"
"""Name in the configuration's file of the hash of all else in it, so that an edited file is noticed."""
HASH_DIGITS = 16
LARGEST = 1e39
"""Largest possible metric: metrics are 32-bit floats."""


class RunError(ValueError):
    """A run folder that can't be used. The message names it, says what is wrong and what to do, in one line."""


def is_empty(folder: Path) -> bool:
    """Return whether a folder is empty, apart from what a process that was killed immediately may have left."""
    return all(path.name == LOCK or is_unfinished(path) for path in folder.iterdir())


def check_new(path: Path) -> None:
    """Raise RunError unless a folder can be made there (or filled, if it is empty). Writes nothing."""
    if path.is_dir() and not is_empty(path):
        hint = f"continue it with `jaxwalk train --resume {path}`, or " if (path / CONFIG).is_file() else ""
        raise RunError(f"{path}: the folder is not empty; {hint}name another folder")
    if path.exists() and not path.is_dir():
        raise RunError(f"{path}: is a file, not a folder; name another folder")
    check_writable(path)


def check_writable(path: Path) -> None:
    """Raise RunError unless this process may create or write the folder. Writes nothing."""
    there = path.absolute()
    while not there.exists():
        there = there.parent
    if not there.is_dir():
        raise RunError(f"{path}: {there} is a file, so nothing can be put into it; name another folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise RunError(f"{path}: no permission to write to {there}; name another folder")


class Run:
    """One run folder."""

    def __init__(
        self, path: str | Path, experiment: Experiment, *, hash: str | None = None, intact: bool | None = True
    ) -> None:
        """Use `create` or `open` instead."""
        self.path = Path(path)
        self.experiment = experiment
        self.hash = hash or config_hash(as_json(experiment))
        """The hash of the configuration as it was written, perhaps by a version that had fewer fields."""
        self.intact = intact
        """Whether the configuration is as jaxwalk wrote it; None if that isn't known, in folders of older versions."""

    @classmethod
    def create(
        cls,
        path: str | Path,
        experiment: Experiment,
        maps: Sequence[MapText] | None = None,
        archives: Sequence[bytes] | None = None,
    ) -> Run:
        """Create a run folder, which must be empty if it exists. The configuration names each generated street.

        ``maps`` and ``archives`` are those of the experiment, if they are read already.
        """
        from jaxwalk.maps import each_map, read_map

        check_new(Path(path))
        experiment = replace(experiment, maps=each_map(experiment.maps))
        maps = [read_map(name) for name in experiment.maps] if maps is None else maps
        archives = [archive_contents(name) for name in experiment.archives] if archives is None else archives
        run = cls(path, experiment)
        with held(run.path):
            check_new(run.path)  # check again: another process may have been quicker
            keep_archives(run.path, archives)  # first: without a configuration, half a folder is no run
            run.describe(experiment)
            keep_maps(run.path, maps)
        return run

    @classmethod
    def open(cls, path: str | Path) -> Run:
        """Open an existing run folder."""
        path = Path(path)
        if not path.is_dir():
            raise RunError(f"{path}: no such run folder; check the name, or train one: `jaxwalk train --run {path}`")
        if not (path / CONFIG).is_file():
            raise RunError(f"{path}: is no run folder, it has no {CONFIG}; name a folder that `jaxwalk train` wrote")
        experiment, found, intact = _read_experiment(path / CONFIG)
        return cls(path, experiment, hash=found, intact=intact)

    @property
    def checkpoints(self) -> Path:
        """Return the folder of the checkpoints."""
        return self.path / CHECKPOINTS

    @property
    def policy(self) -> Path:
        """Return the file of the trained actors."""
        return self.path / POLICY

    def maps(self, tell: Callable[[str], None] = to_stderr) -> tuple[MapText, ...]:
        """Return the maps that it is trained on, as `kept_maps` does."""
        return kept_maps(self.path, self.experiment.maps, tell)

    @property
    def archives(self) -> list[Path]:
        """Return the copies of the archives that it mixes in. Raise KeptArchiveError if one is missing."""
        return kept_archives(self.path, len(self.experiment.archives))

    def describe(self, experiment: Experiment, *, write: bool = True) -> None:
        """Take a configuration, and write it; ``write``: False in a process that leaves writing to another one."""
        document = as_json(experiment)
        self.experiment, self.hash, self.intact = experiment, config_hash(document), True
        if write:
            write_whole(self.path / CONFIG, json.dumps(document | {HASH: self.hash}, indent=2) + "\n")

    def metrics(self) -> list[dict[str, Any]]:
        """Return the lines of the metrics file; [] if there is none yet. Leaves out an incomplete last line."""
        path = self.path / METRICS
        if not path.is_file():
            return []
        try:
            lines = path.read_text(encoding="utf-8").split("\n")[:-1]
            return [_metrics(line) for line in lines]
        except (ValueError, RecursionError) as error:
            raise RunError(f"{path}: damaged ({error}); restore it from a copy, or delete it") from error

    def keep_metrics(self, updates: int) -> list[dict[str, Any]]:
        """Keep the lines up to that update and return them; the later ones are dropped, as they will come again."""
        lines = [line for line in self.metrics() if line["update"] <= updates]
        write_whole(self.path / METRICS, "".join(map(_line, lines)))
        return lines


class MetricsLog:
    """Appends to a run's metrics file and TensorBoard events. Use it in a ``with``."""

    def __init__(self, run: Run, *, updates: int = 0) -> None:
        """Continue after the given number of updates; drop later lines of an interrupted run."""
        self.kept = run.keep_metrics(updates)
        self._path = run.path / METRICS
        self._board = Board(run.path, first=updates + 1)
        self._file = self._path.open("a", encoding="utf-8")

    def __enter__(self) -> MetricsLog:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            with naming(self._path):
                self._file.close()
        finally:
            self._board.close()

    def write(self, line: Mapping[str, int | float]) -> None:
        """Write the metrics of one update, ``update`` among them."""
        with naming(self._path):
            self._file.write(_line(line))
            self._file.flush()
        self._board.write(line)

    def to_disk(self) -> None:
        """Wait until all lines are on the disk."""
        with naming(self._path):
            os.fsync(self._file.fileno())


class NoLog:
    """What a process has instead of a `MetricsLog` if another one writes."""

    kept: tuple[dict[str, Any], ...] = ()

    def __enter__(self) -> NoLog:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def write(self, line: Mapping[str, int | float]) -> None:
        """Write nothing."""

    def to_disk(self) -> None:
        """Wait for nothing."""


def _metrics(line: str) -> dict[str, int | float]:
    """Return the metrics in a line. Raises ValueError unless they are numbers by name, with `update` and `seconds`."""
    found = json.loads(line)
    if not isinstance(found, dict) or not isinstance(found.get("update"), int) or "seconds" not in found:
        raise ValueError(f"a line has no number of the update, or of the seconds: {shorten(line, 40)}")
    for name, value in found.items():
        if type(value) not in (int, float) or not abs(value) <= LARGEST:
            raise ValueError(f"{shorten(name, 40)} must be a number up to {LARGEST:g}, not {shorten(repr(value), 40)}")
    return found


def _line(metrics: Mapping[str, int | float]) -> str:
    return json.dumps(metrics, allow_nan=False) + "\n"


def as_json(experiment: Experiment) -> dict[str, Any]:
    """Return a configuration as its file has it, without the hash."""
    return _experiments().dump_python(experiment, mode="json")


def from_json(document: Mapping[str, Any]) -> Experiment:
    """Return a configuration from what `as_json` returned. Raises ValidationError if it is wrong."""
    return _experiments().validate_json(json.dumps(document))


def config_hash(document: Mapping[str, Any]) -> str:
    """Return the hash of a configuration that `as_json` returned."""
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()[:HASH_DIGITS]


def _without_hash(text: bytes) -> tuple[bytes, str | None, bool | None]:
    """Return a configuration's file without its hash, the hash, and whether the file states it (None: states none)."""
    try:
        document = json.loads(text)
        stated = document.pop(HASH, None)
        found = config_hash(document)
        return json.dumps(document).encode(), found, None if stated is None else stated == found
    except (ValueError, TypeError, AttributeError, RecursionError):
        return text, None, None  # validation reports what is wrong


@cache
def _experiments() -> Any:
    """Return a TypeAdapter[Experiment]."""
    return TypeAdapter(Experiment)


def _with_roles(text: bytes) -> bytes:
    """Return a configuration with its roles in one mapping; version 0.1 had a field of ``train`` for each."""
    try:
        document = json.loads(text)
        train = document["train"]
        if "roles" not in train:
            train["roles"] = {role: train.pop(role) for role in ("driver", "pedestrian")}
    except (ValueError, TypeError, KeyError, RecursionError):
        return text  # validation reports what is wrong
    return json.dumps(document).encode()


def _read_experiment(path: Path) -> tuple[Experiment, str | None, bool | None]:
    """Return the configuration of a file, its hash, and whether it is as jaxwalk wrote it."""
    advice = "correct it, or copy it again from where the run was made"
    try:
        text, found, intact = _without_hash(path.read_bytes().removeprefix(codecs.BOM_UTF8))
        return _experiments().validate_json(_with_roles(text)), found, intact
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"] if part not in ("int", "float"))  # members of unions
        what = f"{where}: {first['msg']}" if where else first["msg"]
        raise RunError(f"{path}: {what}; {advice}") from error
    except OSError as error:
        raise RunError(f"{path}: can't be read ({error.strerror}); check its permissions") from error
