"""A folder that a command fills step by step. If interrupted, the command continues it when it is run again.

runs/NAME/seed-N       a training
plan.json              what was asked for
minutes.json           how long each part took
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any, ClassVar, Generic, Self, TypeVar

from rich.console import Console

from jaxwalk.maps import each_map
from jaxwalk.recipes import Experiment, with_training
from jaxwalk.relief import relieve
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.folder import Run, RunError, check_writable, is_empty
from jaxwalk.runs.lock import held
from jaxwalk.runs.progress import Display
from jaxwalk.runs.street import shared_out
from jaxwalk.runs.training import is_finished, train_in
from jaxwalk.sim.environment import Street
from jaxwalk.wording import counted
from jaxwalk.writing import remove_unfinished, write_whole

PLAN = "plan.json"
"""File of what was asked for."""


class Interrupted(Exception):
    """Ctrl-C interrupted the command; finished parts are kept."""


P = TypeVar("P", bound=Effort)


@dataclass(frozen=True)
class Work(Generic[P]):
    """A folder, a plan, and a function that reports progress."""

    command: ClassVar[str]
    """Name of the command that fills the folder."""
    may_change: ClassVar[tuple[str, ...]] = ()
    """Fields of the plan that may be asked for otherwise later: what is finished stays right."""

    folder: Path
    plan: P
    console: Console
    base: Experiment
    """The experiment from which every training is derived."""

    def run(self, name: str, seed: int) -> Path:
        """Return the folder of a training."""
        return run_folder(self.folder, name, seed)

    def json(self, name: str) -> Any:
        """Return the document of a finished part; None if it isn't finished."""
        return read_json(self.folder / name, self.command)

    def done(self, name: str) -> bool:
        """Return whether the document of a part is there; say so if it is."""
        there = self.json(name) is not None
        if there:
            self.say("    there already")
        return there

    def keep(self, name: str, document: Any) -> None:
        """Write the document of a finished part."""
        write_whole(self.folder / name, json.dumps(document, indent=2, allow_nan=False) + "\n")

    def say(self, text: str) -> None:
        """Report progress."""
        self.console.print(text, soft_wrap=True, markup=False)

    def street(self) -> Street:
        """Return the street to evaluate on."""
        return Street.create(self.base.maps, self.base.sim, jaywalk_multiplier=self.base.jaywalk_multiplier)

    def do(self, steps: Sequence[tuple[str, Callable[[Self], None]]]) -> None:
        """Make the folder, or check that it was made for the same plan; then do each titled step in order.

        Raises InUseError if another process fills the folder.
        """
        self._check()
        with held(self.folder):
            self._check()  # check again: another process may have been quicker
            remove_unfinished(self.folder)
            self.keep(PLAN, asdict(self.plan))
            self._do(steps)

    def _do(self, steps: Sequence[tuple[str, Callable[[Self], None]]]) -> None:
        for number, (name, step) in enumerate(steps, 1):
            self.say(f"[{number}/{len(steps)}] {name}")
            begun = time.monotonic()
            try:
                step(self)
            except BaseException:
                with suppress(OSError):  # if the disk is full, an error says so already
                    self._count_minutes(step, begun)
                raise
            self._count_minutes(step, begun)

    def train(self, name: str, experiment: Experiment, seed: int) -> None:
        """Train with that seed; skip it if finished, resume it if started.

        Raises Interrupted on Ctrl-C, and RunError if the folder holds another training.
        """
        folder, said, wanted = (
            self.run(name, seed),
            f"    {name}, seed {seed}",
            shared_out(replace(experiment, seed=seed)),
        )
        begun = (folder / "config.json").is_file()
        run = Run.open(folder) if begun else Run.create(folder, wanted)
        if not is_same_training(run.experiment, wanted):
            raise RunError(f"{folder}: holds another training than this study's; remove it and run the command again")
        if is_finished(run):
            steps = run.experiment.train.updates * run.experiment.steps_per_update
            self.say(f"{said}: there already, {counted(steps, 'step')}")
            return
        relieve()
        trained = train_in(run, resume=begun, display=Display(self.console, said))
        if trained.interrupted:
            raise Interrupted
        self.say(f"{said}: {counted(trained.steps, 'step')} in {trained.seconds / 60:.1f} minutes")
        if trained.heard:
            raise Interrupted

    def _check(self) -> None:
        """Raise RunError unless the folder can be started or continued. Writes nothing."""
        folder, other = self.folder, "name another folder"
        filled = folder.is_dir() and not is_empty(folder)  # before the plan is read: another process may just write it
        there = self.json(PLAN)
        if there is None and filled:
            raise RunError(f"{folder}: the folder is not empty and no `jaxwalk {self.command}` made it; {other}")
        if there is not None and (name := self._asked_otherwise(there)):
            raise RunError(f"{folder}: was begun with another value of {name}; ask for the same again, or {other}")
        check_writable(folder)

    def _asked_otherwise(self, there: Any) -> str | None:
        """Return the first field of the plan, as it is in the folder, that isn't as asked for now; None if all are.

        A field that an older version didn't have yet is read as its default: what that version did.
        """
        asked, usual = (json.loads(json.dumps(asdict(plan))) for plan in (self.plan, type(self.plan)()))
        there = there if isinstance(there, dict) else {}
        there = {name: usual[name] for name in usual if name not in asdict(Effort())} | there
        differ = (name for name in asked if name not in there or there[name] != asked[name])
        unknown = ("plan" for _ in there.keys() - asked.keys())
        return next((name for name in chain(differ, unknown) if name not in self.may_change), None)

    def _count_minutes(self, step: Callable[[Self], None], begun: float) -> None:
        """Add the time of this part to that of earlier sessions."""
        name, document = step.__name__.strip("_"), self.json("minutes.json") or {}
        document[name] = round(document.get(name, 0.0) + (time.monotonic() - begun) / 60, 3)
        self.keep("minutes.json", document)


def is_same_training(found: Experiment, wanted: Experiment) -> bool:
    """Return whether a training is the wanted one, on whatever machine it began, and however many updates fit in."""
    free = ("shards", "chunk_rows", *(["updates"] if wanted.minutes else []))
    here = {name: getattr(wanted.train, name) for name in free}
    found = replace(with_training(found, **here), minutes=wanted.minutes)
    return found == replace(wanted, maps=each_map(wanted.maps))


def run_folder(folder: Path, name: str, seed: int) -> Path:
    """Return the folder of a training inside a study's folder."""
    return folder / "runs" / name / f"seed-{seed}"


def read_json(path: Path, command: str) -> Any:
    """Return the content of a JSON file that the command wrote; None if there is no file."""
    if not path.is_file():
        return None
    try:
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except (ValueError, RecursionError) as error:
        again = f"delete it and run `jaxwalk {command}` again"
        advice = "restore it from a copy, or name another folder" if path.name == PLAN else again
        raise RunError(f"{path}: damaged ({error}); {advice}") from error
