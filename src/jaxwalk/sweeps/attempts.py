"""Attempts at a trial whose process ended meanwhile, as when the machine's memory runs out or somebody kills it.

Each makes an empty file in the trial's folder before it begins, since such an end leaves nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from jaxwalk.runs.folder import CHECKPOINTS
from jaxwalk.runs.study import Interrupted
from jaxwalk.sweeps.trial_work import UselessTrialError
from jaxwalk.writing import mark, unmark

if TYPE_CHECKING:
    from optuna.trial import Trial

MOST = 3
"""Attempts, one after the other, in which the process may end before the trial has come further."""


@contextmanager
def attempted(trial: Trial, folder: Path) -> Iterator[None]:
    """Count the block as an attempt, unless somebody interrupts it or it ends with an error about the user's files.

    An error such as that of memory that doesn't suffice counts.

    Raises UselessTrialError instead if `MOST` attempts before it came no further.
    """
    come = _come(trial, folder)
    attempts = [folder / f".attempt-{number}-after-{come}.part" for number in range(MOST)]
    mine = next((path for path in attempts if not path.exists()), None)
    if mine is None:
        raise UselessTrialError(
            f"{folder}: its process ended {MOST} times before it came further; the memory may not suffice for it"
        )
    mark(mine)
    try:
        yield
    except (KeyboardInterrupt, SystemExit, Interrupted, OSError, ValueError):  # said to the user, who can do something
        unmark(mine)
        raise
    unmark(mine)


def _come(trial: Trial, folder: Path) -> int:
    """Return how far a trial has come: it is more after each checkpoint, and after each seed that has its number."""
    numbers = sum(name.startswith("seed-") for name in trial.user_attrs)
    kept = (path.name for path in folder.glob(f"seed-*/{CHECKPOINTS}/*"))
    return numbers + sum(int(name) for name in kept if name.isdecimal())
