"""Kill a training again and again, and see that it ends as if nothing had happened.

    python tests/reliability/kill_training.py --kills 50 --seed 0

Trainings of a second or two are killed (SIGKILL) at random moments: while they start, between updates, and as soon as a
checkpoint is being written; then they are gone on with. Each one that comes to its end must equal, to the bit, one that
was never touched: networks, optimisers, environments, keys, policy file, metrics without gaps or doubles, TensorBoard's
view of the events. Exit code 1 if anything differs, or can't be gone on with. Some minutes; needs fork, so no Windows.
"""

from __future__ import annotations

import argparse
import io
import multiprocessing
import os
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from rich.console import Console

from jaxwalk.policies import load_policy
from jaxwalk.recipes import RECIPES, Experiment, with_training
from jaxwalk.runs.folder import METRICS, Run
from jaxwalk.runs.progress import Display
from jaxwalk.runs.street import make_street
from jaxwalk.runs.training import begin, train_in
from jaxwalk.writing import is_unfinished

UPDATES = 24
"""Of each training."""
MOMENTS = ("checkpoint", "update", "after", "start")
"""In a checkpoint's write, some updates after the start, right after a checkpoint, while it starts."""
PATIENCE = 300.0
"""A training that shows nothing for so many seconds hangs."""
FORKS = multiprocessing.get_context("forkserver")


class HangsError(Exception):
    """A training came to no end."""


def small() -> Experiment:
    """A training whose updates take milliseconds."""
    fast = RECIPES["fast"]
    changes = {"actor_hidden": (8,), "critic_hidden": (8,), "epochs": 1}
    roles = {role: replace(config, **changes) for role, config in fast.train.roles.items()}
    return with_training(fast, environments=8, shards=2, steps=8, minibatches=2, updates=UPDATES, roles=roles)


def sit(folder: str, checkpoint_minutes: float) -> None:
    """What is killed: begin the training, or go on with it."""
    jax.config.update("jax_num_cpu_devices", 2)
    path = Path(folder)
    run = Run.open(path) if (path / "config.json").is_file() else Run.create(path, small())
    train_in(
        run,
        resume=True,
        display=Display(Console(file=io.StringIO()), watch=True),
        checkpoint_minutes=checkpoint_minutes,
    )


def begun(folder: Path, checkpoint_minutes: float = 1e-9) -> Any:
    """A process that trains there."""
    process = FORKS.Process(target=sit, args=(str(folder), checkpoint_minutes))
    process.start()
    return process


def finish(folder: Path) -> None:
    """Train to the end. HangsError if it takes too long, RuntimeError if it fails."""
    process = begun(folder)
    process.join(PATIENCE)
    if process.exitcode is None:
        process.kill()
        raise HangsError(f"{folder}: no end after {PATIENCE:.0f} s")
    if process.exitcode:
        raise RuntimeError(f"{folder}: the training ended with exit code {process.exitcode}")


def kill(folder: Path, moment: str, chance: random.Random) -> str | None:
    """Go on with the training and kill it at such a moment; what was going on then, None if it was at its end."""
    before, process = _written(folder), begun(folder, chance.choice((1e-9, 0.002)))
    if moment == "start":
        process.join(chance.uniform(0.0, 8.0))
    else:
        wanted = before + chance.randint(1, 5)
        _until(process, lambda: _written(folder) >= wanted)
        if moment != "update":
            _until(process, lambda: _writing(folder))
        if moment == "after":
            _until(process, lambda: not _writing(folder))
        time.sleep(chance.uniform(0.0, 0.05))
    process.kill()
    process.join()
    if process.exitcode == 0:
        return None
    if process.exitcode != -signal.SIGKILL:
        raise RuntimeError(f"{folder}: the training ended with exit code {process.exitcode}")
    return "checkpoint" if _writing(folder) else "training" if _written(folder) > before else "start"


def _until(process: Any, happens: Callable[[], bool]) -> None:
    """Wait for it, or for the process's end."""
    begun_at = time.monotonic()
    while process.is_alive() and not happens():
        time.sleep(0.001)
        if time.monotonic() - begun_at > PATIENCE:
            process.kill()
            raise HangsError(f"nothing happened for {PATIENCE:.0f} s")


def _written(folder: Path) -> int:
    """Lines of metrics."""
    file = folder / METRICS
    return file.read_bytes().count(b"\n") if file.is_file() else 0


def _writing(folder: Path) -> bool:
    """Whether a checkpoint is begun and not whole."""
    return any((folder / "checkpoints").glob("*.orbax-checkpoint-tmp*"))


def usable(folder: Path) -> None:
    """What is there can be read, so that nothing is half-written; raises otherwise."""
    if not (folder / "config.json").is_file():
        return
    run = Run.open(folder)
    run.metrics()
    if run.policy.is_file():
        load_policy(run.policy, "driver")


def differences(cut: Path, whole: Path) -> list[str]:
    """In what two finished trainings differ."""
    a, b = Run.open(cut), Run.open(whole)
    learners = zip(_learner(a), _learner(b), strict=True)
    found = [f"array {name}" for (name, x), (_, y) in learners if not np.array_equal(x, y)]
    if a.policy.read_bytes() != b.policy.read_bytes():
        found.append("policy.safetensors")
    if [line["update"] for line in a.metrics()] != list(range(1, UPDATES + 1)):
        found.append("updates in metrics.jsonl")
    if _timeless(a.metrics()) != _timeless(b.metrics()):
        found.append("metrics.jsonl")
    if board(cut) != board(whole) or len(board(cut)) != UPDATES:
        found.append("TensorBoard's events")
    if (cut / "config.json").read_bytes() != (whole / "config.json").read_bytes():
        found.append("config.json")
    left = [path.name for path in (*cut.iterdir(), *(cut / "checkpoints").iterdir()) if _is_left(path)]
    return found + [f"left over: {name}" for name in left]


def _is_left(path: Path) -> bool:
    return is_unfinished(path) or "orbax-checkpoint-tmp" in path.name


def _learner(run: Run) -> list[tuple[str, Any]]:
    learner = begin(run, make_street(run.experiment), resume=True)
    return [
        (jax.tree_util.keystr(at), jax.random.key_data(x) if jnp.issubdtype(x.dtype, jax.dtypes.prng_key) else x)
        for at, x in jax.tree_util.tree_leaves_with_path(learner)
    ]


def _timeless(lines: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{name: x for name, x in line.items() if name != "seconds"} for line in lines]


def board(folder: Path) -> dict[int, dict[str, float]]:
    """Each update's numbers as TensorBoard shows them; ValueError for one that it would show twice."""
    from tensorboardX.proto.event_pb2 import Event, SessionLog  # pyright: ignore

    shown: dict[int, dict[str, float]] = {}
    for file in sorted(folder.glob("events.out.tfevents.*")):
        for event in map(Event.FromString, _records(file.read_bytes())):
            if event.HasField("session_log") and event.session_log.status == SessionLog.START:
                shown = {step: values for step, values in shown.items() if step < event.step}
            elif event.HasField("summary"):
                values = {value.tag: value.simple_value for value in event.summary.value if value.tag != "seconds"}
                if event.step in shown:
                    raise ValueError(f"{file}: update {event.step} comes twice")
                shown[event.step] = values
    return shown


def _records(content: bytes) -> list[bytes]:
    """The whole records of a file of events: length, its checksum, content, its checksum."""
    found, at = [], 0
    while at + 12 <= len(content):
        length = int.from_bytes(content[at : at + 8], "little")
        if at + 16 + length > len(content):
            break
        found.append(content[at + 12 : at + 12 + length])
        at += 16 + length
    return found


def kill_often(folder: Path, kills: int, seed: int, say: Callable[[str], None] = print) -> list[str]:
    """Trainings in the folder, killed so many times in all; what was wrong."""
    chance, hit, wrong, ended = random.Random(seed), Counter[str](), [], 0
    whole, number = folder / "whole", 0
    finish(whole)
    say("the training that is never touched has ended")
    while hit.total() < kills:
        cut = folder / f"cut-{number}"
        happened = kill(cut, MOMENTS[hit.total() % len(MOMENTS)], chance)
        usable(cut)
        if happened is not None:
            hit[happened] += 1
            if hit.total() % 5 == 0:
                say(f"{hit.total()} kills; training {number} has written {_written(cut)} updates")
        if happened is None or hit.total() == kills:
            finish(cut)
            wrong += [f"{cut.name}: {what}" for what in differences(cut, whole)]
            number, ended = number + 1, ended + 1
    hits = ", ".join(f"{what} {count}" for what, count in sorted(hit.items()))
    say(f"{kills} kills (by what went on: {hits}); trainings that came to their end: {ended}")
    return wrong


def report(check: Callable[[Path, Callable[[str], None]], list[str]]) -> int:
    """Do a check of trainings in a temporary folder, and print what is wrong; return the exit code.

    Args:
        check: takes the folder and what prints a line; returns a line about each difference, and raises for what
            can't be gone on with.
    """
    jax.config.update("jax_num_cpu_devices", 2)
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(Path(folder) / "compiled"))
        os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
        FORKS.set_forkserver_preload(["jaxwalk.runs.training", "orbax.checkpoint"])
        try:
            wrong = check(Path(folder), partial(print, flush=True))
        except (HangsError, RuntimeError, ValueError) as error:
            wrong = [str(error)]
    print("\n".join(wrong) or "all of them equal the training that was never touched", flush=True)
    print("FAILED" if wrong else "passed")
    return 1 if wrong else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    return report(lambda folder, say: kill_often(folder, options.kills, options.seed, say))


if __name__ == "__main__":
    sys.exit(main())
