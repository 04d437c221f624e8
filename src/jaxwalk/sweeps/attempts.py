"""Attempts at a trial whose process ended meanwhile, as when the machine's memory runs out or somebody kills it.

The journal counts them before they begin, as such an end leaves nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from jaxwalk.runs.folder import CHECKPOINTS
from jaxwalk.runs.study import Interrupted
from jaxwalk.sweeps.trial_work import UselessTrialError

if TYPE_CHECKING:
    from optuna.trial import Trial

MOST = 3
"""Attempts, one after the other, in which the process may end before the trial has come further."""
ATTEMPTS = "attempts"
"""Note in the journal: how far the trial had come, and how many attempts began there."""


@contextmanager
def attempted(trial: Trial, folder: Path) -> Iterator[None]:
    """Count the block as an attempt, unless somebody interrupts it or it ends with a message.

    Raises UselessTrialError instead if `MOST` attempts before it came no further.
    """
    come = _come(trial, folder)
    before, count = trial.user_attrs.get(ATTEMPTS, (come, 0))
    count = count if before == come else 0
    if count >= MOST:
        raise UselessTrialError(
            f"{folder}: its process ended {count} times before it came further; the memory may not suffice for it"
        )
    trial.set_user_attr(ATTEMPTS, [come, count + 1])
    try:
        yield
    except (KeyboardInterrupt, Interrupted, OSError, ValueError):  # said to the user, who can do something about it
        with suppress(OSError):  # the disk may be full
            trial.set_user_attr(ATTEMPTS, [come, count])
        raise


def _come(trial: Trial, folder: Path) -> int:
    """Return how far a trial has come: it is more after each checkpoint, and after each seed that has its number."""
    numbers = sum(name.startswith("seed-") for name in trial.user_attrs)
    kept = (path.name for path in folder.glob(f"seed-*/{CHECKPOINTS}/*"))
    return numbers + sum(int(name) for name in kept if name.isdecimal())
