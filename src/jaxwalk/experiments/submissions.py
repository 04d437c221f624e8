"""`jaxwalk submit`: entries of a leaderboard, each a folder that others can check.

NAME/
  README.md       what the driver is and who made it
  results.json    of `jaxwalk evaluate`, called in this folder
  ...             the files of the driver, and of people of one's own
  checked.json    of `jaxwalk submit --check`: the same evaluation on scenarios of a seed that follows from these files
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import chdir
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from jaxwalk.evaluation import Results
from jaxwalk.experiments.again import AgainError, Comparison, compare_documents, evaluation_again, read_document
from jaxwalk.experiments.entry_files import CHECKED, SubmissionError, copy_of, fresh_seed, missing_file
from jaxwalk.experiments.evaluating import Tell, evaluate_all
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.policies.host.borrowed_modules import modules_of
from jaxwalk.writing import write_whole

CARD, RESULTS = "README.md", "results.json"
FEWEST = 2000
"""Fewest scenarios of an entry: the interval of a driver without a collision in them ends at 0.18 %."""


@dataclass(frozen=True)
class Entry:
    """A folder that follows the convention."""

    folder: Path
    results: Results
    """What its author found."""
    checked: Results | None
    """What a checker found on fresh scenarios; None if nobody has checked these very files."""

    @property
    def name(self) -> str:
        """The name of the folder."""
        return self.folder.resolve().name

    @property
    def shown(self) -> Results:
        """The results to show: the checked ones, if there are any."""
        return self.checked or self.results


def read_entry(folder: Path, salt: str | None = None) -> Entry:
    """Return the entry in a folder; ``salt`` is what its check was made with.

    Raises:
        SubmissionError: a file is missing or a link, or the results are not those of one driver whose files are all
            here, on `FEWEST` drawn scenarios.
        MixtureError, AgainError, DocumentError: ``results.json`` or ``checked.json`` can't be read.
    """
    for name, what in ((CARD, "says what the driver is"), (RESULTS, "`jaxwalk evaluate --out` writes")):
        if not (folder / name).is_file():
            raise SubmissionError(f"{folder}: has no {name}, which {what}; see `jaxwalk submit --help`")
    results = read_document(folder / RESULTS)
    _check(folder, results)
    fresh = Scenarios(results.scenarios.count, fresh_seed(folder, results, salt))
    checked = read_document(folder / CHECKED) if (folder / CHECKED).is_file() else None
    return Entry(folder, results, checked if checked and _same_work(results, checked, fresh) else None)


def _check(folder: Path, results: Results) -> None:
    """Raise SubmissionError unless the results are ones that can stand in a leaderboard."""
    path, again = folder / RESULTS, f"evaluate again in {folder}, with --out"
    if len(results.drivers) != 1:
        raise SubmissionError(f"{path}: is of {len(results.drivers)} drivers; an entry is one: {again}")
    if results.street is None or results.options is None or results.scenarios.seed is None:
        raise SubmissionError(f"{path}: is not of drawn scenarios, or of an older version; {again}")
    if results.scenarios.count < FEWEST:
        few = f"{results.scenarios.count:,} scenarios are too few, {FEWEST:,} are needed"
        raise SubmissionError(f"{path}: {few}; {again} --episodes {FEWEST}")
    named = [("driver", one.name) for one in results.drivers] + [
        ("pedestrian", one.name) for one in results.populations
    ]
    for missing in (missing_file(folder, role, name) for role, name in named):
        if missing is not None:
            raise SubmissionError(f"{path}: {missing} is not in {folder}; put its file there, and {again}")


def _same_work(results: Results, checked: Results, fresh: Scenarios) -> bool:
    """Return whether both are of the same policies in the same world, and the second one of the fresh scenarios."""
    same = all(getattr(results, x) == getattr(checked, x) for x in ("drivers", "populations", "street", "options"))
    return same and (checked.scenarios.count, checked.scenarios.seed) == (fresh.episodes, fresh.seed)


def check_entry(entry: Entry, tell: Tell, *, salt: str | None, **loading: Any) -> tuple[Entry, Comparison]:
    """Make an entry's results again, then evaluate it on fresh scenarios, and keep what was found in its folder.

    All is played in a copy of the entry's files, so that nothing takes part which the seed doesn't follow from.

    Args:
        entry: its driver is loaded and runs.
        tell: called with progress.
        salt: the fresh seed follows from it too; None for no salt.
        loading: how `contestant` loads drivers (``trust``, ``seconds``).

    Returns:
        The entry as checked, and how its results come out again. If they differ, nothing else is played, and no check
        stays in the folder.

    Raises:
        AgainError: a driver or population is missing, or another one than the results are of.
        SubmissionError: the driver, or somebody else, changed files of the entry meanwhile.
        DriverError: it imports a module from elsewhere, or can't be used.
        Stopped: a policy failed.
    """
    folder, count = entry.folder.resolve(), entry.results.scenarios.count
    with copy_of(folder) as copy:
        fresh = Scenarios(count, fresh_seed(copy, entry.results, salt))
        found, checked = _played(entry, copy, fresh, tell, loading)
        same = all(fresh_seed(place, entry.results, salt) == fresh.seed for place in (copy, folder))
    if checked is None:
        (folder / CHECKED).unlink(missing_ok=True)
        return replace(entry, checked=None), found
    if not same:
        raise SubmissionError(
            f"{entry.folder}: its files were changed during the check; let its driver write elsewhere, and check again"
        )
    write_whole(folder / CHECKED, checked.to_json())
    return replace(entry, checked=checked), found


def _played(
    entry: Entry, copy: Path, fresh: Scenarios, tell: Tell, loading: Mapping[str, Any]
) -> tuple[Comparison, Results | None]:
    """Return how an entry's results come out again, and what it does on fresh scenarios; None if they differ."""
    home = entry.folder.resolve()
    with chdir(copy), modules_of(copy, home) as check_modules:  # names in the results are seen from there
        try:
            work = evaluation_again(Path(RESULTS), entry.results, out=None, **loading)
        except AgainError as error:
            raise AgainError(f"{entry.folder}: {error}") from error
        check_modules()
        found = compare_documents(entry.results, evaluate_all(work, tell))
        return found, None if found.differs else evaluate_all(replace(work, scenarios=fresh), tell)
