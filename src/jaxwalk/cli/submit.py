"""``jaxwalk submit``."""

from __future__ import annotations

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from jaxwalk.cli.checks import check_driver_seconds, check_file
from jaxwalk.cli.errors import DIFFERS, UsageError
from jaxwalk.cli.options import Submit
from jaxwalk.experiments.submissions import Entry, check_entry, read_entry
from jaxwalk.report.leaderboard import page, standings
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held
from jaxwalk.writing import write_whole


def run(options: Submit) -> int:
    """Read all entries, check them if that is asked for, and show the leaderboard."""
    check(options)
    entries, came_out = [read_entry(folder) for folder in options.entries], True
    if options.check:
        checked = [_checked(entry, options) for entry in entries]
        entries, came_out = [entry for entry, _ in checked], all(same for _, same in checked)
    text = page([one for entry in entries for one in standings(entry.name, entry.shown, checked=bool(entry.checked))])
    if options.out:
        write_whole(options.out, text)
        print(f"Read {options.out}")
    else:
        print(text, end="")
    return 0 if came_out else DIFFERS


def check(options: Submit) -> None:
    """Raise UsageError for impossible options."""
    if not options.entries:
        raise UsageError("a folder is missing: an entry, with README.md, results.json and the driver's files")
    for folder in options.entries:
        if not folder.is_dir():
            raise UsageError(f"{folder}: no such folder; check the name")
    names = [folder.resolve().name for folder in options.entries]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise UsageError(f"two folders are called {twice}; a leaderboard shows their names, so rename one")
    check_driver_seconds(options.driver_seconds)
    if options.out:
        check_file(options.out, ".md")
        check_writable(options.out.parent)
    if options.check:
        for folder in options.entries:
            check_writable(folder)


def _checked(entry: Entry, options: Submit) -> tuple[Entry, bool]:
    """Check an entry, say what came of it, and return whether it came out again."""
    with held(entry.folder), Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("evaluating", total=None)

        def tell(what: str, done: int, total: int) -> None:
            bar.update(task, description=escape(f"{entry.name}: {what}"), completed=done, total=total)

        entry, found = check_entry(entry, tell, trust=options.trust, seconds=options.driver_seconds)
    Console(stderr=True).print(f"{entry.name}: {found.in_words}", soft_wrap=True, markup=False)
    return entry, not found.differs
