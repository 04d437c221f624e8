"""Play batch after batch of scenarios in the same columns: where an episode has ended, the next one begins.

A batch takes as long as its longest episode, two to four times as long as the mean one, and all of its columns are
computed until then. An evaluation of several batches ends sooner if no column waits for the others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int, Key, Shaped

from jaxwalk.evaluation.broken import ActionError
from jaxwalk.evaluation.playing import BLOCK, Endings, begin, host_driver, play, play_block, recording, unsound_actions
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.trajectory import Trajectory, part_of

NOBODY = -1
"""In place of an episode's number: nobody plays in this place of the batch."""


@dataclass(frozen=True)
class Batch:
    """A batch of scenarios, of which the first ``count`` are to be played; the others fill it up."""

    numbers: Int[np.ndarray, "episode"]
    scenarios: Scenario
    keys: Key[Array, "episode"]
    count: int


Played = tuple[Batch, Trajectory]
"""A batch, and the recording of the episodes that were to be played."""


def played(street: Street, policies: Roles[Policy], batches: Iterator[Batch]) -> Iterator[Played]:
    """Begin to play batches of one size, at least one; return an iterator over them, in their order.

    Their recordings equal those of `jaxwalk.evaluation.play`, of each batch alone, to the last bit. A `HostDriver` is
    asked by batches, so with one each batch is played to its end.

    Raises:
        DriverError: a `HostDriver` failed.
        ActionError: an action of another policy isn't in its space. The batches before are given out first.
    """
    if host_driver(policies) is None:
        return _Columns(street, policies, batches).finished()
    return (_played_alone(street, policies, batch) for batch in batches)


def _played_alone(street: Street, policies: Roles[Policy], batch: Batch) -> Played:
    trajectory = play(street, policies, batch.scenarios, batch.keys, numbers=batch.numbers)
    return batch, part_of(trajectory, frames=len(trajectory.car_x), episodes=slice(batch.count))


Piece = tuple[int, Int[np.ndarray, "episode"], dict[str, np.ndarray]]
"""The number of a block, which episodes have played it, and their frames ``(frame, ..., episode)``."""


class _Started:
    """A batch of which episodes have begun, and what is recorded of them."""

    def __init__(self, street: Street, policies: Roles[Policy], batch: Batch) -> None:
        """Make the start of every episode."""
        self.batch = batch
        self.setup, self.game, first = begin(street, policies, batch.scenarios, batch.keys)
        self.first = {name: np.asarray(x)[..., : batch.count] for name, x in first.items()}
        """Frame 0."""
        self.pieces: list[Piece] = []
        self.endings = Endings(*(np.array(x[..., : batch.count]) for x in Endings.of(self.game)))
        self.ended_in = np.zeros(batch.count, int)
        """The block in which each episode has ended; 0 if it hasn't."""
        self.seated = 0
        """How many episodes have a column, or had one."""
        self.errors: dict[int, ActionError] = {}
        """Errors of actions that ended an episode."""

    @property
    def complete(self) -> bool:
        """Whether all episodes have ended."""
        return bool(self.ended_in.all())

    def seat(self, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give free columns to the next episodes; return these columns, and which episodes have them."""
        columns = free[: self.batch.count - self.seated]
        episodes = self.seated + np.arange(columns.size)
        self.seated += columns.size
        return columns, episodes

    def record(self, block: int, frames: Mapping[str, np.ndarray], columns: np.ndarray, episodes: np.ndarray) -> None:
        """Keep the block of this number, from 1 on, of some episodes, which have been played in these columns."""
        self.pieces.append((block, episodes, {name: x[..., columns] for name, x in frames.items()}))

    def note_endings(self, episodes: np.ndarray, now: Endings, columns: np.ndarray, blocks: np.ndarray) -> None:
        """Note how some episodes have ended, in which columns, and in which of their blocks."""
        for mine, theirs in zip(self.endings, now, strict=True):
            mine[..., episodes] = theirs[..., columns]
        self.ended_in[episodes] = blocks

    def recorded(self, street: Street) -> Trajectory:
        """Return the recording, once all episodes have ended. Raise the first episode's error if there is one."""
        if self.errors:
            raise self.errors[min(self.errors)]
        columns = {name: self._whole(name) for name in self.first}
        return recording(street, self.batch.scenarios, self.batch.numbers, self.endings, columns)

    def _whole(self, name: str) -> Shaped[np.ndarray, "frame ..."]:
        """Return all frames of a recorded quantity; after its end, an episode repeats its last one."""
        first = self.first[name]
        whole = np.empty((self.endings.length.max() + 1, *first.shape), first.dtype)
        whole[0] = first
        for block, episodes, frames in self.pieces:
            part = whole[_frames_of(block)]
            part[..., episodes] = frames[name][: len(part)]
        for block in range(2, self.ended_in.max() + 1):
            part, before = whole[_frames_of(block)], whole[_frames_of(block - 1)]
            over = np.flatnonzero(self.ended_in < block)
            part[..., over] = before[-1:, ..., over]
        return whole


def _frames_of(block: int) -> slice:
    """Return which frames a block of an episode has, after frame 0."""
    return slice(1 + (block - 1) * BLOCK, 1 + block * BLOCK)


class _Columns:
    """The columns of a batch, and what is played in them."""

    def __init__(self, street: Street, policies: Roles[Policy], batches: Iterator[Batch]) -> None:
        """Begin the first batch, and play its first block."""
        self.street, self.policies, self.coming = street, policies, batches
        begun = _Started(street, policies, next(batches))
        self.numbered = count(1)
        self.open = {0: begun}
        """Batches that have begun and aren't given out yet, by their number, oldest first."""
        size = len(begun.batch.numbers)
        self.owner, self.episode = np.full((2, size), NOBODY)
        """The batch's number, and which of its episodes is played, in each column."""
        self.blocks, self.scenario = np.zeros((2, size), int)
        """How many blocks of this episode have been played, and the number of its scenario."""
        self.setup, self.game = begun.setup, replace(begun.game, ended=jnp.ones(size, bool))
        self._begin_next()
        self._play_block()

    def finished(self) -> Iterator[Played]:
        """Yield each batch as soon as it and those before are complete."""
        while self.open:
            first = next(iter(self.open))
            if self.open[first].complete:
                begun = self.open.pop(first)
                yield begun.batch, begun.recorded(self.street)
            else:
                self._play_block()
            self._begin_next()

    def _play_block(self) -> None:
        """Play a block in every column, and record it."""
        self.game, recorded = play_block(self.setup, self.game, BLOCK)
        frames = {name: np.asarray(x) for name, x in recorded.items()}
        self.blocks += 1
        over, now = np.asarray(self.game.ended), Endings.of(self.game)
        for number, begun in self.open.items():
            mine = self.owner == number
            for block in np.unique(self.blocks[mine]).tolist():
                columns = np.flatnonzero(mine & (self.blocks == block))
                begun.record(block, frames, columns, self.episode[columns])
            columns = np.flatnonzero(mine & over)
            begun.note_endings(self.episode[columns], now, columns, self.blocks[columns])
        self._note_errors()
        self.owner[over] = NOBODY

    def _note_errors(self) -> None:
        """Keep the errors of actions that aren't in their space."""
        for column, error in unsound_actions(self.street, self.game, self.scenario):
            if self.owner[column] != NOBODY:
                self.open[self.owner[column]].errors[self.episode[column]] = error

    def _begin_next(self) -> None:
        """Begin the next episodes wherever none is played."""
        while (free := np.flatnonzero(self.owner == NOBODY)).size and (number := self._waiting()) is not None:
            begun = self.open[number]
            columns, episodes = begun.seat(free)
            self.owner[columns], self.episode[columns], self.blocks[columns] = number, episodes, 0
            self.scenario[columns] = begun.batch.numbers[episodes]
            which = np.full(self.owner.size, NOBODY)
            which[columns] = episodes
            before = self.setup.scenarios, self.setup.keys, self.game
            fresh = begun.setup.scenarios, begun.setup.keys, begun.game
            scenarios, keys, self.game = _seated(before, fresh, jnp.asarray(which))
            self.setup = replace(self.setup, scenarios=scenarios, keys=keys)

    def _waiting(self) -> int | None:
        """Return the number of the batch of which an episode begins next; None if all have begun."""
        for number, begun in self.open.items():
            if begun.seated < begun.batch.count:
                return number
        for number, batch in zip(self.numbered, self.coming, strict=False):
            self.open[number] = _Started(self.street, self.policies, batch)
            return number
        return None


@eqx.filter_jit
def _seated(before: Any, fresh: Any, which: Int[Array, "column"]) -> Any:
    """Return arrays ``(..., column)`` with the fresh episode of the given number in each column that has one."""
    return jax.tree.map(lambda old, new: jnp.where(which >= 0, new[..., which], old), before, fresh)
