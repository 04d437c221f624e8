"""``jaxwalk train --processes N``: starts the processes of a training on this machine, and ends them together.

The processes find each other on the loopback address. Process 0 shows its progress here; what others print, and
messages of the libraries of all of them, is kept for the case that one fails. When a process has ended, or gives no
sign of life, all are ended.
"""

from __future__ import annotations

import math
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.cli.early import check_names
from jaxwalk.cli.errors import BAD_INPUT, INTERRUPTED, LOST
from jaxwalk.cli.group import SILENCE, check_processes, shards_of
from jaxwalk.cli.options import Train
from jaxwalk.cli.signals import TERMINATED
from jaxwalk.runs.folder import CHECKPOINTS, CONFIG
from jaxwalk.runs.stop import Stop
from jaxwalk.runs.watchdog import HUNG, LAUNCHED

GRACE = 5.0
"""Time that processes have to end by themselves after one has failed [s]."""
EVERY = 0.1
"""Time between two looks at the processes [s]."""
ENDED_WELL = (0, INTERRUPTED, TERMINATED)
"""Exit codes of processes that came to their end together."""
CUT_SHORT = (*ENDED_WELL, LOST, -signal.SIGTERM, -signal.SIGABRT, None)
"""Exit codes of processes after a signal: also of one that the signal or JAX ended, and of one that we are about to."""
WELL, CUT, FAILED = "in order", "cut short by a signal", "failed"
"""How processes end together."""
LEFT_ALONE = (*ENDED_WELL, LOST, HUNG)
"""Exit codes of processes that have no error of their own."""
LAST_WORDS = 4000
"""Longest part of what a failed process printed that is shown [characters]."""


@dataclass
class Member:
    """A process of the group."""

    number: int
    process: subprocess.Popen[bytes]
    printed: Path
    """File of what it prints, but for the messages of process 0."""
    line: socket.socket
    """Where it shows that it lives."""
    heard: float
    """When it last did [s]."""

    @property
    def code(self) -> int | None:
        """Return its exit code; None while it runs, and -N if signal N ended it."""
        return self.process.poll()

    def is_silent(self) -> bool:
        """Return whether it runs and has given no sign of life for long."""
        with suppress(BlockingIOError):
            while self.line.recv(4096):
                self.heard = time.monotonic()
        return self.code is None and time.monotonic() - self.heard > SILENCE


def launch(options: Train, words: Sequence[str]) -> int:
    """Start the processes of a training, wait for their end, and return the exit code.

    Args:
        options: the options of ``jaxwalk train``.
        words: the words of the command line after ``jaxwalk``.
    """
    check_processes(options)
    check_names(options)
    shards_of(options)
    with Stop().listening() as stop:
        left = options.restarts
        while (code := _train(options, words, stop, left)) == LOST and left and not stop.requested:
            words, left = _words_to_resume(options, words), left - 1
    return code


def _train(options: Train, words: Sequence[str], stop: Stop, restarts: int) -> int:
    """Train until all processes have ended, in order or together with one that was lost; return the exit code."""
    with _started(words, options.processes) as members:
        end = _wait(members, stop)
        if end == CUT:
            print(f"jaxwalk: interrupted; {_kept(options)}; {_how_to_resume(options, words)}", file=sys.stderr)
            return INTERRUPTED
        if end == FAILED:
            again = "it begins again" if restarts and not stop.requested else None
            return _report_failure(options, words, members, again)
        codes = [member.code or 0 for member in members]
    return max(codes) and INTERRUPTED


def _report_failure(options: Train, words: Sequence[str], members: Sequence[Member], again: str | None) -> int:
    """Print one message about what has happened, unless process 0 has; return the exit code."""
    codes = [member.code for member in members]
    failing = [number for number, code in enumerate(codes) if (code or 0) > 0 and code not in LEFT_ALONE]
    if 0 in failing:
        return codes[0] or 0
    if failing:
        said = _printed(members[failing[0]])
        print(f"jaxwalk: process {failing[0]} of {len(members)} failed:\n{said}", file=sys.stderr)
        return BAD_INPUT
    next_step = again or _how_to_resume(options, words)
    what, lost = _what_happened(members)
    print(f"jaxwalk: {what}, and the training ended; {_kept(options)}; {next_step}", file=sys.stderr)
    said = "" if lost is None else _printed(members[lost])
    if said:
        print(f"Process {lost} said:\n{said}", file=sys.stderr)
    return LOST


def _wait(members: Sequence[Member], stop: Stop) -> str:
    """Wait until all processes have ended, or some time after one has failed; return how: WELL, CUT or FAILED.

    A signal to this process is handed on to all of them, once. What fails before it wasn't cut short by it.
    """
    told, cut, until = False, False, math.inf
    while any(member.code is None for member in members) and time.monotonic() < until:
        if until == math.inf and any(member.code not in (None, *ENDED_WELL) for member in members):
            until = time.monotonic() + GRACE
        if stop.requested and not told:
            told, cut = True, until == math.inf
            _tell_to_end(members)
        if any([member.is_silent() for member in members]):
            return FAILED
        time.sleep(EVERY)
    if all(member.code in ENDED_WELL for member in members):
        return WELL
    return CUT if cut and all(member.code in CUT_SHORT for member in members) else FAILED


def _tell_to_end(members: Sequence[Member]) -> None:
    """Ask all processes to end in order. Not by an interrupt, which shells let background processes ignore."""
    for member in members:
        member.process.terminate()


def _what_happened(members: Sequence[Member]) -> tuple[str, int | None]:
    """Return how the processes were lost, by how all are before the rest of them is ended; and which was killed."""
    codes = [member.code for member in members]
    killed = [(code == -signal.SIGABRT, number, -code) for number, code in enumerate(codes) if code and code < 0]
    if killed:  # an abort comes last: so JAX ends those that have lost another one
        _, number, by = min(killed)
        return f"process {number} of {len(codes)} was killed ({signal.Signals(by).name})", number
    if HUNG in codes:
        return "a process hangs, so that no update was finished for long", None
    silent = [str(member.number) for member in members if member.is_silent()]
    if silent:
        return f"process {' and '.join(silent)} of {len(codes)} gave no sign of life for {SILENCE} s", None
    return "the processes lost each other", None


def _kept(options: Train) -> str:
    """Return what there is to resume from."""
    folder = _folder(options) / CHECKPOINTS
    numbers = [int(path.name) for path in folder.glob("*") if path.name.isdecimal()]
    return f"the checkpoint of update {max(numbers)} is kept" if numbers else "there is no checkpoint yet"


def _how_to_resume(options: Train, words: Sequence[str]) -> str:
    """Return what to do to go on."""
    return f"resume it with: jaxwalk {' '.join(_words_to_resume(options, words))}"


def _words_to_resume(options: Train, words: Sequence[str]) -> list[str]:
    """Return the command line that goes on; the given one if its folder hasn't come into being."""
    if not (_folder(options) / CONFIG).is_file():
        return list(words)
    extra = ["--watch"] if options.watch else []
    if options.checkpoint_minutes != Train.checkpoint_minutes:
        extra += ["--checkpoint-minutes", f"{options.checkpoint_minutes:g}"]
    return ["train", "--resume", str(_folder(options)), "--processes", str(options.processes), *extra]


def _folder(options: Train) -> Path:
    """Return the run folder."""
    return options.resume or options.run_folder or Path()


@contextmanager
def _started(words: Sequence[str], count: int) -> Iterator[list[Member]]:
    """Yield running processes; at the end, all of them are ended."""
    address = f"127.0.0.1:{free_port()}"
    with tempfile.TemporaryDirectory(prefix="jaxwalk-") as folder, ExitStack() as ends:
        members: list[Member] = []
        for number in range(count):
            command = _command([*words, "--coordinator", address], number)
            members.append(_start(command, number, Path(folder) / str(number)))
            ends.enter_context(members[-1].process)
            ends.callback(members[-1].process.kill)
            ends.enter_context(members[-1].line)
        yield members


def _command(words: Sequence[str], number: int) -> list[str]:
    """Return the command line of process ``number``."""
    return [sys.executable, "-m", "jaxwalk", *words, "--process", str(number)]


def _start(command: Sequence[str], number: int, printed: Path) -> Member:
    """Start a process in a session of its own, so that Ctrl-C in a terminal reaches it only from here.

    Its standard input is one end of the line on which it shows that it lives, and sees that this process has ended.
    """
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    with theirs, printed.open("wb") as out:
        shown = os.dup(2 if number == 0 else out.fileno())
        process = subprocess.Popen(
            command, stdin=theirs.fileno(), stdout=out, stderr=out, env=os.environ | {LAUNCHED: str(shown)},
            pass_fds=(shown,), start_new_session=True,
        )  # fmt: skip
        os.close(shown)
    return Member(number, process, printed, ours, time.monotonic())


def _printed(member: Member) -> str:
    """Return the last words of a process."""
    return member.printed.read_text(errors="backslashreplace").strip()[-LAST_WORDS:]


def free_port() -> int:
    """Return a port of the loopback address that nobody uses now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]
