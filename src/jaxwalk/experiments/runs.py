"""The run folder: all that a training leaves behind, and all that evaluation needs.

    config.json         the `Experiment`
    metrics.jsonl       one line for each update
    events.out.*        the same for TensorBoard
    checkpoints/        to resume from
    policy.safetensors  the trained actors, with where they come from

Files are written under another name and renamed when whole.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from jaxwalk.experiments.recipes import Experiment

CONFIG, METRICS, CHECKPOINTS, POLICY = "config.json", "metrics.jsonl", "checkpoints", "policy.safetensors"
"""Names inside a run folder."""


class RunError(ValueError):
    """A run folder that can't be used; one line names it, says what is wrong and what to do."""


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file so that it is there whole or not at all."""
    unfinished = path.with_name(f".{path.name}.{os.getpid()}.part")
    unfinished.write_bytes(content.encode() if isinstance(content, str) else content)
    unfinished.replace(path)


def check_new(path: Path) -> None:
    """Raise RunError unless a folder can be made (or filled, if empty) there. Writes nothing."""
    if path.is_dir() and any(path.iterdir()):
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

    def __init__(self, path: str | Path, experiment: Experiment) -> None:
        """Use `create` or `open` instead."""
        self.path = Path(path)
        self.experiment = experiment

    @classmethod
    def create(cls, path: str | Path, experiment: Experiment) -> Run:
        """A new folder; an existing one must be empty."""
        check_new(Path(path))
        Path(path).mkdir(parents=True, exist_ok=True)
        run = cls(path, experiment)
        run.describe(experiment)
        return run

    @classmethod
    def open(cls, path: str | Path) -> Run:
        """A folder that was written before."""
        path = Path(path)
        if not path.is_dir():
            raise RunError(f"{path}: no such run folder; check the name, or train one: `jaxwalk train --run {path}`")
        if not (path / CONFIG).is_file():
            raise RunError(f"{path}: is no run folder, it has no {CONFIG}; name a folder that `jaxwalk train` wrote")
        return cls(path, _read_experiment(path / CONFIG))

    @property
    def checkpoints(self) -> Path:
        """Where checkpoints are."""
        return self.path / CHECKPOINTS

    @property
    def policy(self) -> Path:
        """The file of the trained actors."""
        return self.path / POLICY

    def describe(self, experiment: Experiment) -> None:
        """Write the configuration."""
        self.experiment = experiment
        write_whole(self.path / CONFIG, _experiments().dump_json(experiment, indent=2) + b"\n")

    def metrics(self) -> list[dict[str, Any]]:
        """The lines of the metrics file; [] if there is none yet. A last line cut short is left out."""
        path = self.path / METRICS
        if not path.is_file():
            return []
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        try:
            return [json.loads(line) for line in lines if line.endswith("\n")]
        except json.JSONDecodeError as error:
            raise RunError(f"{path}: damaged ({error}); restore it from a copy, or delete it") from error

    def keep_metrics(self, updates: int) -> list[dict[str, Any]]:
        """Drop the lines after so many updates, which will come again; returns those kept."""
        lines = [line for line in self.metrics() if line["update"] <= updates]
        write_whole(self.path / METRICS, "".join(map(_line, lines)))
        return lines


class MetricsLog:
    """Appends to a run's metrics file and TensorBoard events. Use it in a ``with``."""

    def __init__(self, run: Run, *, updates: int = 0) -> None:
        """Go on after so many updates: later lines of an interrupted run are dropped."""
        from tensorboardX import SummaryWriter

        self.kept = run.keep_metrics(updates)
        self._file = (run.path / METRICS).open("a", encoding="utf-8")
        purge = updates + 1 if updates else None
        self._board: Any = SummaryWriter(str(run.path), purge_step=purge)

    def __enter__(self) -> MetricsLog:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
        self._board.close()

    def write(self, line: Mapping[str, int | float]) -> None:
        """One update's metrics, ``update`` among them."""
        self._file.write(_line(line))
        self._file.flush()
        for name, value in line.items():
            if name != "update":
                self._board.add_scalar(name, value, line["update"])


def _line(metrics: Mapping[str, int | float]) -> str:
    return json.dumps(metrics, allow_nan=False) + "\n"


def _experiments() -> Any:
    """A TypeAdapter[Experiment]."""
    return TypeAdapter(Experiment)


def _read_experiment(path: Path) -> Experiment:
    mend = "mend it, or copy it again from where the run was made"
    try:
        return _experiments().validate_json(path.read_bytes())
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"] if part not in ("int", "float"))  # members of unions
        what = f"{where}: {first['msg']}" if where else first["msg"]
        raise RunError(f"{path}: {what}; {mend}") from error
    except OSError as error:
        raise RunError(f"{path}: can't be read ({error.strerror}); check its permissions") from error
