"""Evaluate the policies of all roles on the scenarios of a source.

The course of a scenario depends only on the scenario and its key. All batches have the same size on the device (the
last one repeats scenarios), so row i is the same to the last bit for any number of scenarios. Another batch size may
round differently.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from jaxwalk.evaluation.ghosts import walk_ghosts
from jaxwalk.evaluation.playing import play
from jaxwalk.evaluation.unhindered import unhindered_times, with_delay
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.maps import map_labels
from jaxwalk.metrics import Rows, measure
from jaxwalk.relief import relieve
from jaxwalk.scenarios import Source
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.trajectory import Ghosts, Trajectory, part_of

BATCH = 512
"""Default number of episodes played at once."""
AT_ONCE = 2
"""Number of batches in progress at once: on a CPU, much of a batch keeps only one core busy."""

Progress = Callable[[int, int], None]
"""Called with the number done so far, and the total."""


def evaluate(
    street: Street, policies: Roles[Policy], source: Source, *,
    batch: int | None = None, progress: Progress | None = None,
) -> Rows:  # fmt: skip
    """Play all scenarios of a source and measure them.

    Args:
        street: the world.
        policies: the policy of each role.
        source: the scenarios.
        batch: episodes in a batch (default: `BATCH`), of which `AT_ONCE` are in progress at a time; memory grows with
            it, about 0.4 MB per episode.
        progress: called after every batch with the number of episodes played so far, and the total.

    Raises:
        ValueError: ``batch`` is below 1.
        DriverError: a driver that is not JAX failed.
        ActionError: an action of another policy isn't in its space.
    """
    return Rows.join(list(evaluate_batches(street, policies, source, batch=batch, progress=progress)))


def evaluate_batches(
    street: Street, policies: Roles[Policy], source: Source, *,
    batch: int | None = None, progress: Progress | None = None, span: range | None = None,
) -> Iterator[Rows]:  # fmt: skip
    """Yield the parts that `evaluate` joins, one batch at a time, as soon as each is played.

    With a ``span``, which begins at a multiple of ``batch``: only the rows of its scenarios, equal to the last bit.
    """
    batch = _size(batch)
    episodes, config = len(source), street.config
    span = range(episodes) if span is None else span
    if span.start % batch or not 0 <= span.start < span.stop <= episodes:
        raise ValueError(f"a span must begin at a multiple of {batch} and lie in [0, {episodes}), not be {span}")
    maps = np.array(map_labels(street.maps), object)
    times = unhindered_times(street)

    def recorded(first: int) -> tuple[Scenario, Trajectory, Ghosts]:
        numbers = (first + np.arange(batch)) % episodes
        scenarios, keys = source.take(numbers)
        trajectory = play(street, policies, scenarios, keys, numbers=numbers)
        return scenarios, trajectory, walk_ghosts(street, scenarios, keys, frames=len(trajectory.car_x))

    def rows(first: int) -> Rows:
        scenarios, trajectory, ghosts = begun.pop(first) if first in begun else recorded(first)
        frames, asked = len(trajectory.car_x), slice(min(batch, span.stop - first))
        measured = measure(
            part_of(trajectory, frames=frames, episodes=asked),
            part_of(ghosts, frames=frames, episodes=asked),
            config=config,
        )
        known = with_delay(measured, times, scenarios)
        return replace(known, maps=maps[np.asarray(scenarios.map)[asked]])

    begun = {span.start: recorded(span.start)}  # alone, so that its programs are compiled only once
    with ThreadPoolExecutor(AT_ONCE) as pool:
        for number, part in enumerate(pool.map(rows, range(span.start, span.stop, batch)), 1):
            if progress is not None:
                progress(min(number * batch, len(span)), len(span))
            yield part
    relieve()


def replay(
    street: Street, policies: Roles[Policy], source: Source, numbers: Sequence[int], *, batch: int | None = None
) -> Trajectory:
    """Return the episodes of some scenarios of a source, as `evaluate` plays them with the same ``batch``.

    Raises:
        ValueError: there are no ``numbers`` or more than ``batch``, the source lacks one of them, or ``batch`` is
            below 1.
    """
    batch = _size(batch)
    chosen = np.asarray(numbers, np.int64)
    if not 0 < len(chosen) <= batch:
        raise ValueError(f"replay takes 1 to {batch} scenarios at once, not {len(chosen)}")
    full = np.resize(chosen, batch)  # repeated to a full batch, so that nothing is compiled again
    scenarios, keys = source.take(full)
    trajectory = play(street, policies, scenarios, keys, numbers=full)
    count = len(chosen)
    return part_of(trajectory, frames=int(trajectory.length[:count].max()) + 1, episodes=slice(count))


def _size(batch: int | None) -> int:
    """Return the number of episodes played at once. Raise ValueError if it is below 1."""
    if batch is not None and batch < 1:
        raise ValueError(f"batch must be at least 1, not {batch}")
    return BATCH if batch is None else batch
