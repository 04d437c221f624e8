"""``jaxwalk submit``."""

from __future__ import annotations

import sys
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from jaxwalk.cli.checks import check_driver_seconds, check_file
from jaxwalk.cli.errors import BAD_INPUT, DIFFERS, UsageError, message
from jaxwalk.cli.options import Submit
from jaxwalk.evaluation import Stopped
from jaxwalk.evaluation.counterfactual import ReplayError
from jaxwalk.evaluation.reading import DocumentError
from jaxwalk.experiments.again import AgainError
from jaxwalk.experiments.entry_files import SubmissionError
from jaxwalk.experiments.submissions import Entry, check_entry, read_entry
from jaxwalk.maps.file import MapError
from jaxwalk.policies.host.driver import DriverError
from jaxwalk.policies.learned import PolicyError
from jaxwalk.policies.mixture_names import MixtureError
from jaxwalk.report.leaderboard import LONGEST_NAME, BoardLine, StandingsError, page, standings
from jaxwalk.runs.contestant_names import ContestantError
from jaxwalk.runs.folder import RunError, check_writable
from jaxwalk.runs.lock import InUseError, held
from jaxwalk.wording import plain
from jaxwalk.writing import write_whole

LONGEST_FINDING = 1000
"""Longest line on how an entry's results come out again [characters]."""
UNUSABLE = (
    SubmissionError, StandingsError, AgainError, DocumentError, MixtureError, ContestantError, DriverError, PolicyError,
    MapError, ReplayError, Stopped, RunError, InUseError, UsageError, OSError,
)  # fmt: skip
"""Faults of an entry: of its files, its results or its driver. Any other error isn't the entry's, and ends it all."""


def run(options: Submit) -> int:
    """Read all entries, check them if that is asked for, and show the leaderboard with those that can't be used."""
    check(options)
    lines: list[BoardLine] = []
    unusable: dict[str, str] = {}
    came_out = True
    for folder in options.entries:
        try:
            found, same = _found(folder, options)
            lines += found
            came_out &= same
        except UNUSABLE as error:
            unusable[folder.resolve().name] = message(error) or str(error)
    for why in unusable.values():
        print(f"jaxwalk: {why}", file=sys.stderr)
    if lines:
        _show(page(lines, unusable, salted=options.salt is not None), options.out)
    return BAD_INPUT if unusable else 0 if came_out else DIFFERS


def _show(text: str, out: Path | None) -> None:
    """Write the leaderboard into a file, or print it."""
    if out:
        write_whole(out, text)
        print(f"Read {out}")
    else:
        print(text, end="")


def check(options: Submit) -> None:
    """Raise UsageError for impossible options."""
    if not options.entries:
        raise UsageError("a folder is missing: an entry, with README.md, results.json and the driver's files")
    names = [folder.resolve().name for folder in options.entries]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise UsageError(f"two folders are called {twice}; a leaderboard shows their names, so rename one")
    check_driver_seconds(options.driver_seconds)
    if options.salt == "":
        raise UsageError("--salt is empty; give a long random text, or leave it out")
    if options.out:
        check_file(options.out, ".md")
        check_writable(options.out.parent)


def _found(folder: Path, options: Submit) -> tuple[list[BoardLine], bool]:
    """Return an entry's lines, checked if that is asked for, and whether it came out again."""
    if not folder.is_dir():
        raise UsageError(f"{folder}: no such folder; check the name")
    if options.check:
        check_writable(folder)
    entry = read_entry(folder, options.salt)
    lines = _lines(entry)
    if not options.check:
        return lines, True
    entry, same = _checked(entry, options)
    return _lines(entry), same


def _lines(entry: Entry) -> list[BoardLine]:
    return standings(entry.name, entry.shown, checked=entry.checked is not None)


def _checked(entry: Entry, options: Submit) -> tuple[Entry, bool]:
    """Check an entry, say what came of it, and return whether it came out again."""
    name = plain(entry.name, LONGEST_NAME)
    with held(entry.folder), Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("evaluating", total=None)

        def tell(what: str, done: int, total: int) -> None:
            bar.update(task, description=escape(plain(f"{name}: {what}")), completed=done, total=total)

        entry, found = check_entry(entry, tell, salt=options.salt, trust=options.trust, seconds=options.driver_seconds)
    said = plain(f"{name}: {found.in_words}", LONGEST_FINDING)
    Console(stderr=True).print(said, soft_wrap=True, markup=False, highlight=False)
    return entry, not found.differs
