"""Kill or stop processes of a training by several again and again, and see that all end, and that it can be resumed.

    python tests/reliability/kill_processes.py --kills 20 --stops 10 --seed 0

`jaxwalk train --processes 2` runs a small training. A random one of its processes gets SIGKILL or SIGSTOP at a random
moment: while it starts, between updates, while a checkpoint is written. The command must end within a minute, with exit
code 3, one message that names the process, and no process left; the same command then goes on. Each training that comes
to its end must equal one that a single process made with two shards and nobody touched, to the bit: networks,
optimisers, environments, keys, policy file, metrics, TensorBoard's view. Exit code 1 if anything differs. Linux only.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from jaxwalk.runs.folder import METRICS, Run
from reliability.kill_training import HangsError, differences, finish, report, small, usable

PROCESSES = 2
MINUTE = 60.0
"""The rest must have ended by then [s]."""
PATIENCE = 600.0
"""A training that shows nothing for so many seconds hangs."""


class WrongEndError(RuntimeError):
    """The command ended otherwise than it promises."""


def begun(folder: Path, log: Path) -> subprocess.Popen[bytes]:
    """The command, going on with the training in the folder."""
    command = [sys.executable, "-m", "jaxwalk", "train", "--resume", str(folder), "--processes", str(PROCESSES)]
    with log.open("wb") as file:
        return subprocess.Popen([*command, "--checkpoint-minutes", "1e-9"], stderr=file)


def members(launcher: subprocess.Popen[bytes]) -> list[int]:
    """The processes that the command has started, in their order."""
    path = Path(f"/proc/{launcher.pid}/task/{launcher.pid}/children")
    return sorted(map(int, path.read_text().split())) if path.exists() else []


def strike(folder: Path, number: signal.Signals, chance: random.Random) -> tuple[str, float] | None:
    """Go on with the training, strike one of its processes, and wait for the end of all of them.

    Returns what went on then, and the seconds until the end; None if the training was at its end before.
    """
    log, before = folder.with_suffix(".log"), written(folder)
    launcher = begun(folder, log)
    try:
        _until(launcher, lambda: len(members(launcher)) == PROCESSES, PATIENCE)
        if chance.random() < 0.2:
            time.sleep(chance.uniform(0.0, 8.0))
        else:
            wanted = before + chance.randint(1, 5)
            _until(launcher, lambda: written(folder) >= wanted, PATIENCE)
            time.sleep(chance.uniform(0.0, 0.3))
        pids, victim = members(launcher), chance.randrange(PROCESSES)
        if launcher.poll() is not None or len(pids) < PROCESSES:
            launcher.wait(MINUTE)
            return None
        at = time.monotonic()
        os.kill(pids[victim], number)
        _until(launcher, lambda: False, MINUTE)
        if launcher.returncode == 0:
            return None
        seconds = time.monotonic() - at
        _check_end(launcher, pids, log.read_text(), f"process {victim} of {PROCESSES}")
        return "training" if written(folder) > before else "start", seconds
    finally:
        launcher.kill()
        launcher.wait()


def _check_end(launcher: subprocess.Popen[bytes], pids: list[int], said: str, victim: str) -> None:
    """Raise WrongEndError unless the command has ended as it promises."""
    if launcher.returncode != 3:
        raise WrongEndError(f"exit code {launcher.returncode}, not 3: {said}")
    if said.count("jaxwalk: ") != 1 or victim not in said or "Traceback" in said:
        raise WrongEndError(f"not one message about {victim}: {said}")
    left = [pid for pid in pids if Path(f"/proc/{pid}").exists()]
    if left:
        raise WrongEndError(f"processes {left} are left")


def complete(folder: Path) -> None:
    """Train to the end, by several processes."""
    launcher = begun(folder, folder.with_suffix(".log"))
    _until(launcher, lambda: False, PATIENCE)
    if launcher.returncode:
        raise WrongEndError(f"exit code {launcher.returncode}: {folder.with_suffix('.log').read_text()}")


def _until(launcher: subprocess.Popen[bytes], happens: Callable[[], bool], seconds: float) -> None:
    """Wait for something, or for the command's end. HangsError if it takes too long."""
    until = time.monotonic() + seconds
    while launcher.poll() is None and not happens():
        time.sleep(0.01)
        if time.monotonic() > until:
            raise HangsError(f"nothing happened for {seconds:.0f} s")


def written(folder: Path) -> int:
    """Lines of metrics."""
    file = folder / METRICS
    return file.read_bytes().count(b"\n") if file.is_file() else 0


def strike_often(folder: Path, kills: int, stops: int, seed: int, say: Callable[[str], None] = print) -> list[str]:
    """Trainings in the folder, struck so many times in all; what was wrong."""
    chance, hit, wrong, longest = random.Random(seed), Counter[str](), [], Counter[str]()
    whole, number = folder / "whole", 0
    finish(whole)
    say("the training that is never touched has ended")
    left = [signal.SIGKILL] * kills + [signal.SIGSTOP] * stops
    chance.shuffle(left)
    while left:
        cut = folder / f"cut-{number}"
        if not cut.exists():
            Run.create(cut, small())
        happened = strike(cut, left[-1], chance)
        usable(cut)
        if happened is not None:
            struck = left.pop().name
            hit[f"{struck} in {happened[0]}"] += 1
            longest[struck] = max(longest[struck], round(happened[1]))
            what, seconds = happened
            say(
                f"{struck} in {what}: ended after {seconds:.1f} s; training {number} has written {written(cut)} updates"
            )
        if happened is None or not left:
            complete(cut)
            wrong += [f"{cut.name}: {what}" for what in differences(cut, whole)]
            number += 1
    hits = ", ".join(f"{what} {count}" for what, count in sorted(hit.items()))
    say(f"{hit.total()} strikes ({hits}); longest until the end [s]: {dict(longest)}; trainings compared: {number}")
    return wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--stops", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    return report(lambda folder, say: strike_often(folder, options.kills, options.stops, options.seed, say))


if __name__ == "__main__":
    sys.exit(main())
