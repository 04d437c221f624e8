"""Play faults of environment, streams, signals and disk on every kind of command, and hold them to what is promised.

    .venv/bin/python tests/reliability/faults.py              # each fault on three commands
    .venv/bin/python tests/reliability/faults.py --all        # each on every command
    .venv/bin/python tests/reliability/faults.py PATTERN      # those whose name holds a text

Promised (docs/testing.md): the exit code, at most one message and no traceback, nothing half-written, the end within
5 s of a signal (a training: after the update in flight) and at once at a second one.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from maps.imported.osm_files import cross
from reliability.fault_table import COMMANDS, FAULTS, LONG, OUT, SMALL, WRITES, Fault
from sweeps.tiny_sweep import written

AT_LEAST = 3
"""Number of commands that meet each fault."""
IN_TIME, AT_ONCE, UPDATE = 5.0, 1.0, 60.0
"""Seconds to end after a signal, after a second one, and after one in a training whose update is to be compiled."""
LIMIT = 600.0
"""Seconds after which a command counts as hanging."""
ODD = re.compile(r"Traceback|Exception ignored|Warning:|Fatal|core dumped|^[EF]\d{4} ", re.MULTILINE)
"""What standard error may not hold; the last is how XLA's own errors begin."""


@dataclass(frozen=True)
class Seen:
    """How a command ended."""

    code: int
    err: str
    seconds: float
    """Since the last signal, or since the start."""


def cases(everything: bool, pattern: str) -> Iterator[tuple[Fault, str]]:
    """Yield faults and commands: each fault on some commands, in turns, or on all."""
    turn = 0
    for fault in FAULTS:
        able = [name for name in COMMANDS if name not in fault.without and (fault.ends or name not in LONG)]
        count = len(able) if everything else AT_LEAST
        chosen = [able[(turn + number) % len(able)] for number in range(count)]
        turn += count
        if pattern in fault.name:
            yield from ((fault, name) for name in chosen)


def prepare(folder: Path, cache: Path) -> None:
    """Make what commands read: a run, a table of trajectories, an entry, a part of an evaluation, a town, a sweep."""
    entry = "evaluate --driver route-follower --episodes 2000 --out entry"
    part = "evaluate --driver random --episodes 2 --part 1/1 --out part"
    for line in (f"train --run run {SMALL}", "tracks --driver random --out tracks.parquet", entry, part):
        done = subprocess.run(_command(line), cwd=folder, env=_environment(cache), check=False, capture_output=True)
        assert done.returncode == 0, done.stderr.decode()
    (folder / "entry" / "README.md").write_text("a car that looks at nobody")
    cross().write(folder / "cross.osm")
    written(folder, trials=1)


def play(fault: Fault, name: str, folder: Path, cache: Path) -> Seen:
    """Run the command in a folder with older files, meet it with the fault, and return how it ended."""
    for file in WRITES.get(name, ()):
        (folder / OUT).mkdir(exist_ok=True)
        (folder / OUT / file).write_text("older")
    line = fault.line.replace("J", f"{sys.executable} -m jaxwalk {COMMANDS[name]}")
    line = f"{line}" if "|" in line or ";" in line else f"exec {line}"
    line = line.replace("; " + sys.executable, "; exec " + sys.executable)
    shell = ["/bin/bash", "-o", "pipefail", "-c", line]
    environment = {k: v for k, v in (_environment(cache) | fault.environment).items() if v is not None}
    # What is begun with & or nohup ignores these, and so would our commands.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, lambda *_: None)
    begun = time.monotonic()
    with subprocess.Popen(
        shell, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace"
    ) as process:
        for number, sent in enumerate(fault.send):
            time.sleep(0.7 if number else fault.after)
            begun = time.monotonic()
            process.send_signal(sent)
        try:
            _, err = process.communicate(timeout=LIMIT)
        except subprocess.TimeoutExpired:
            process.kill()
            return Seen(124, "it hangs", LIMIT)
    return Seen(process.returncode, err, time.monotonic() - begun)


def wrong(fault: Fault, name: str, seen: Seen, folder: Path, slack: float) -> list[str]:
    """Return what is not as promised."""
    found = []
    if seen.code not in fault.codes:
        found.append(f"exit code {seen.code}, not one of {fault.codes}")
    found += [f"{odd!r} on standard error" for odd in dict.fromkeys(ODD.findall(seen.err))]
    said = [line for line in seen.err.splitlines() if line.startswith("jaxwalk: ")]
    if len(said) > 1:
        found.append(f"{len(said)} messages")
    if seen.code == 2 and not said and "2>" not in fault.line:
        found.append("no message")
    if fault.send and seen.code != 0:
        twice = len(fault.send) > 1 and fault.send[1] != signal.SIGHUP
        limit = AT_ONCE if twice else UPDATE if name in ("train", *LONG) else IN_TIME
        found += [f"ended after {seen.seconds:.1f} s"] if seen.seconds > slack * limit else []
    half = [path.name for path in folder.rglob("*") if ".part" in path.suffixes[-2:] or "checkpoint-tmp" in path.name]
    found += [f"half-written: {half}"] if half else []
    there = [folder / OUT / file for file in WRITES.get(name, ()) if (folder / OUT / file).is_file()]
    older = [path.name for path in there if path.read_bytes() == b"older"]
    if older and (seen.code == 0 or len(older) != len(there)):
        found.append(f"older files beside new ones: {older}")
    return found


def _command(line: str) -> list[str]:
    return [sys.executable, "-m", "jaxwalk", *line.split()]


def _environment(cache: Path) -> dict[str, str | None]:
    keep = {name: value for name, value in os.environ.items() if not name.startswith(("JAX_", "XLA_"))}
    return {**keep, "JAX_COMPILATION_CACHE_DIR": str(cache), "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}


def main() -> int:
    """Play all cases and print a line for each; return 1 if one isn't as promised."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pattern", nargs="?", default="")
    parser.add_argument("--all", action="store_true", help="each fault on every command")
    parser.add_argument("--slack", type=float, default=2.0, help="times the promised seconds, on a busy machine")
    options = parser.parse_args()
    bad = played = 0
    with tempfile.TemporaryDirectory() as scratch:
        made, cache = Path(scratch) / "made", Path(scratch) / "cache"
        made.mkdir()
        prepare(made, cache)
        for fault, name in cases(options.all, options.pattern):
            folder = Path(scratch) / "case"
            shutil.copytree(made, folder)
            seen = play(fault, name, folder, cache)
            found = wrong(fault, name, seen, folder, options.slack)
            last = (seen.err.strip().splitlines() or [""])[-1][:90]
            print(f"{'WRONG' if found else 'ok':6}{fault.name:28}{name:14}{seen.code:4}{seen.seconds:7.1f} s  {last}")
            print(*(f"      {what}\n{seen.err[-2000:]}" for what in found), sep="\n", end="", flush=True)
            played, bad = played + 1, bad + bool(found)
            shutil.rmtree(folder)
    print(f"{played} cases of {len(FAULTS)} faults, {bad} not as promised")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
