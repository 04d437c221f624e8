"""`jaxwalk submit`: entries of a leaderboard, each a folder that others can check.

NAME/
  README.md       what the driver is and who made it
  results.json    of `jaxwalk evaluate`, called in this folder
  ...             the files of the driver, and of people of one's own
  checked.json    of `jaxwalk submit --check`: the same evaluation on scenarios that the entry's author didn't choose
"""

from __future__ import annotations

import hashlib
from contextlib import chdir
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from jaxwalk.evaluation import Results
from jaxwalk.evaluation.document_parts import PolicyOrigin
from jaxwalk.experiments.again import AgainError, Comparison, compare_documents, evaluation_again, read_document
from jaxwalk.experiments.evaluating import Tell, evaluate_all
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.writing import write_whole

CARD, RESULTS, CHECKED = "README.md", "results.json", "checked.json"
FEWEST = 2000
"""Fewest scenarios of an entry: the interval of a driver without a collision in them ends at 0.18 %."""
INSTALLED = ("rule", "shipped policy")
"""Kinds of policies that come with jaxwalk: an entry needs no file of theirs."""


class SubmissionError(ValueError):
    """A folder is no entry. The message names the folder, what is missing and what to do, in one line."""


@dataclass(frozen=True)
class Entry:
    """A folder that follows the convention."""

    folder: Path
    results: Results
    """What its author found."""
    checked: Results | None
    """What a checker found on fresh scenarios; None if nobody has checked these very results."""

    @property
    def name(self) -> str:
        """The name of the folder."""
        return self.folder.resolve().name

    @property
    def shown(self) -> Results:
        """The results to show: the checked ones, if there are any."""
        return self.checked or self.results


def read_entry(folder: Path) -> Entry:
    """Return the entry in a folder.

    Raises:
        SubmissionError: a file is missing, or the results are not those of one driver whose files are all here, on
            `FEWEST` drawn scenarios.
        AgainError, DocumentError: ``results.json`` or ``checked.json`` can't be read.
    """
    for name, what in ((CARD, "says what the driver is"), (RESULTS, "`jaxwalk evaluate --out` writes")):
        if not (folder / name).is_file():
            raise SubmissionError(f"{folder}: has no {name}, which {what}; see `jaxwalk submit --help`")
    results = read_document(folder / RESULTS)
    _check(folder, results)
    checked = read_document(folder / CHECKED) if (folder / CHECKED).is_file() else None
    return Entry(folder, results, checked if checked and _same_work(results, checked) else None)


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
    for origin in (*results.drivers, *results.populations):
        if origin.kind not in INSTALLED and not _inside(folder, origin):
            raise SubmissionError(f"{path}: {origin.name} is not in {folder}; put its file there, and {again}")


def _inside(folder: Path, origin: PolicyOrigin) -> bool:
    """Return whether what a name stands for lies in the folder, as far as the name says it."""
    path = Path(origin.name.partition(":")[0])
    return not path.is_absolute() and (folder / path).resolve().is_relative_to(folder.resolve())


def _same_work(results: Results, checked: Results) -> bool:
    """Return whether both are of the same policies in the same world."""
    return all(getattr(results, x) == getattr(checked, x) for x in ("drivers", "populations", "street", "options"))


def fresh_seed(results: Results) -> int:
    """Return the seed of a checker's scenarios: it follows from the driver's file, so nobody can choose it."""
    driver = results.drivers[0]
    digest = hashlib.sha256(f"{driver.sha256 or driver.name}".encode()).digest()
    seed = int.from_bytes(digest[:4], "big") % 2**31
    return seed if seed != results.scenarios.seed else (seed + 1) % 2**31


def check_entry(entry: Entry, tell: Tell, **loading: Any) -> tuple[Entry, Comparison]:
    """Make an entry's results again, then evaluate it on fresh scenarios, and keep what was found in its folder.

    Args:
        entry: its driver is loaded and runs.
        tell: called with progress.
        loading: how `contestant` loads drivers (``trust``, ``seconds``).

    Returns:
        The entry as checked, and how its results come out again. If they differ, nothing else is played or written.

    Raises:
        AgainError: a driver or population is missing, or another one than the results are of.
        Stopped: a policy failed.
    """
    folder = entry.folder.resolve()
    with chdir(folder):  # names in the results are seen from there
        try:
            work = evaluation_again(Path(RESULTS), entry.results, out=None, **loading)
        except AgainError as error:
            raise AgainError(f"{entry.folder}: {error}") from error
        found = compare_documents(entry.results, evaluate_all(work, tell))
        if found.differs:
            return replace(entry, checked=None), found
        fresh = Scenarios(entry.results.scenarios.count, fresh_seed(entry.results))
        checked = evaluate_all(replace(work, scenarios=fresh), tell)
    write_whole(folder / CHECKED, checked.to_json())
    return replace(entry, checked=checked), found
