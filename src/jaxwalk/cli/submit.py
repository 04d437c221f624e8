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
from jaxwalk.experiments.submissions import Entry, check_entry, read_entry
from jaxwalk.report.leaderboard import LONGEST_NAME, BoardLine, page, standings
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held
from jaxwalk.wording import plain
from jaxwalk.writing import write_whole

LONGEST_FINDING = 1000
"""Longest line on how an entry's results come out again [characters]."""


def run(options: Submit) -> int:
    """Read all entries, check them if that is asked for, and show the leaderboard with those that can't be used."""
    check(options)
    lines: list[BoardLine] = []
    unusable: dict[str, str] = {}
    came_out = True
    for folder in options.entries:
        try:
            entry, same = _found(folder, options)
            lines += standings(entry.name, entry.shown, checked=bool(entry.checked))
            came_out &= same
        except Exception as error:
            unusable[folder.resolve().name] = _reason(error)
    for why in unusable.values():
        print(f"jaxwalk: {why}", file=sys.stderr)
    if lines:
        _show(page(lines, unusable), options.out)
    return BAD_INPUT if unusable else 0 if came_out else DIFFERS


def _reason(error: Exception) -> str:
    """Return why an entry can't be used. Raise the error if it is one of jaxwalk itself."""
    text = message(error)
    if text is None:
        raise error
    return text


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
    if options.out:
        check_file(options.out, ".md")
        check_writable(options.out.parent)


def _found(folder: Path, options: Submit) -> tuple[Entry, bool]:
    """Return an entry, checked if that is asked for, and whether it came out again."""
    if not folder.is_dir():
        raise UsageError(f"{folder}: no such folder; check the name")
    if options.check:
        check_writable(folder)
    entry = read_entry(folder)
    return _checked(entry, options) if options.check else (entry, True)


def _checked(entry: Entry, options: Submit) -> tuple[Entry, bool]:
    """Check an entry, say what came of it, and return whether it came out again."""
    name = plain(entry.name, LONGEST_NAME)
    with held(entry.folder), Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("evaluating", total=None)

        def tell(what: str, done: int, total: int) -> None:
            bar.update(task, description=escape(plain(f"{name}: {what}")), completed=done, total=total)

        entry, found = check_entry(entry, tell, trust=options.trust, seconds=options.driver_seconds)
    said = plain(f"{name}: {found.in_words}", LONGEST_FINDING)
    Console(stderr=True).print(said, soft_wrap=True, markup=False, highlight=False)
    return entry, not found.differs
