"""One session of a training: from its start or resumption to its end or interruption."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from textwrap import shorten
from typing import Any

import jax
import numpy as np

from jaxwalk.learning import checkpoint
from jaxwalk.learning.mappo import Learner
from jaxwalk.learning.turns import update_in_turns
from jaxwalk.peers import gathered, is_first
from jaxwalk.policies import save_policy
from jaxwalk.provenance import provenance
from jaxwalk.runs.binding import bound_to, policy_bound_to
from jaxwalk.runs.folder import MetricsLog, NoLog, Run, RunError
from jaxwalk.runs.kept_archives import archive_hashes
from jaxwalk.runs.progress import TrainingProgress
from jaxwalk.runs.stop import Stop
from jaxwalk.runs.street import on_devices
from jaxwalk.runs.watch import WatchPage
from jaxwalk.runs.watchdog import Watchdog
from jaxwalk.sim.environment import Street

OnUpdate = Callable[[Mapping[str, int | float]], bool | None]
"""Is called after each update with its line of ``metrics.jsonl``; True ends the training.

By then the next update may have begun: it is made and kept."""


class CallbackError(TypeError):
    """``on_update`` returned neither None nor a truth value."""


class DivergedError(RunError):
    """Training produced a number that is not finite."""


@dataclass(frozen=True)
class Routine:
    """What a session does between updates."""

    checkpoint_seconds: float = 120.0
    """Time between checkpoints [s]."""
    on_update: OnUpdate | None = None
    until: int | None = None
    """Number of updates after which the session ends, though more may be planned. None: all that are planned."""

    def end(self, planned: int) -> int:
        """Return the number of updates after which the session ends."""
        return planned if self.until is None else min(self.until, planned)


@dataclass
class Session:
    """Makes updates, records and shows their metrics, and saves checkpoints."""

    run: Run
    street: Street
    log: MetricsLog | NoLog
    progress: TrainingProgress
    stop: Stop
    page: WatchPage | None = None
    """The page that shows the progress."""
    routine: Routine = Routine()
    """What happens between updates."""
    watchdog: Watchdog | None = None
    """Is told each finished update, if several processes train together."""
    told_to_stop: bool = False
    """Whether ``on_update`` ended the training."""
    begun: float = field(default_factory=time.monotonic)
    """When the session began [s]."""
    earlier: float = 0.0
    """Time spent by earlier sessions [s]."""
    saved: float = field(default_factory=time.monotonic)
    """When the last checkpoint was written [s]."""

    def __post_init__(self) -> None:
        self._config = self.run.experiment.train
        self.turns = on_devices(self.street, self.run.experiment)

    @property
    def seconds(self) -> float:
        """Return the time spent by all sessions [s]."""
        return self.earlier + time.monotonic() - self.begun

    def update(self, learner: Learner, made: int) -> tuple[Learner, Any]:
        """Start the update after that many; return the next learner and its metrics, which may still be computing."""
        return update_in_turns(self.turns, self._config, learner, made)

    def record(self, metrics: Any, updates: int, before: Learner) -> None:
        """Write and show the metrics of an update, waiting for them if necessary.

        If they are not finite or an action isn't in its space, save the learner of ``before`` and raise DivergedError.
        """
        values = {name: float(value) for name, value in jax.device_get(metrics).items()}
        fixed = [role for role in self._config.roles if not values.pop(f"fixed/{role}", True)]
        if not values.pop("finite"):
            self.save(before)
            raise DivergedError(f"{self.run.path}: {_what_diverged(updates, fixed)}")
        values["steps"] = updates * self.run.experiment.steps_per_update
        if len(self.turns) > 1:
            values["people"] = self.turns[(updates - 1) % len(self.turns)].config.pedestrians
        line = {"update": updates, "seconds": round(self.seconds, 3), **values}
        if self.watchdog is not None:
            self.watchdog.finished()
        self.log.write(line)
        self.progress.show(updates, values)
        if self.page is not None:
            self.page.show(line)
        tell = self.routine.on_update
        if tell is not None and _wants_to_stop(tell(dict(line))) and not self.stop.requested:
            self.told_to_stop = self.stop.requested = True

    def save(self, learner: Learner) -> None:
        """Write a checkpoint and the policy of a learner. Its last update is recorded, so its numbers are finite.

        All processes call it, and the first one writes.
        """
        learner, updates = gathered(learner), int(learner.updates)
        if not is_first():
            return
        self.log.to_disk()  # a checkpoint without its metrics would leave a gap
        if checkpoint.latest(self.run.checkpoints) != updates:
            about = bound_to(self.run, self.street.maps, archive_hashes(self.street))
            checkpoint.save(self.run.checkpoints, learner, updates=updates, about=about)
        save_policy(self.run.policy, learner, policy_metadata(self.run, self.street, updates))
        self.saved = time.monotonic()


def _wants_to_stop(answer: object) -> bool:
    """Return whether ``on_update`` ends the training. Raise CallbackError if it answered with something else."""
    if answer is None or isinstance(answer, bool | np.bool_):
        return bool(answer)
    raise CallbackError(
        f"on_update must return True to end the training, or None to go on, not {shorten(repr(answer), 60)}"
    )


def _what_diverged(updates: int, fixed: Sequence[str]) -> str:
    """Return what is wrong with an update, and what to do; ``fixed``: roles whose fixed policy is broken."""
    kept = f"checkpoint and policy of update {updates - 1} are kept"
    if fixed:
        broken = f"the fixed {' and '.join(fixed)} policy gave an action that isn't in its space"
        return f"in update {updates} {broken} (not finite, for example); {kept}. Correct it, and train anew"
    return (
        f"update {updates} gave numbers that are not finite; {kept}. "
        "Train anew with a lower --learning-rate or --reward-scale, or another --seed"
    )


def policy_metadata(run: Run, street: Street, updates: int) -> dict[str, Any]:
    """Return the origin of a policy trained on this street, as its file states it."""
    experiment = run.experiment
    made = {"updates": updates, "steps": updates * experiment.steps_per_update}
    chosen = {"recipe": experiment.recipe, "single_agent": experiment.single_agent, "seed": experiment.seed}
    return chosen | policy_bound_to(run, street.maps, archive_hashes(street)) | made | asdict(provenance())
