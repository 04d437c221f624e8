"""Evaluate the policies of all roles on the scenarios of a source.

The course of a scenario depends only on the scenario and its key. All batches have the same size on the device (the
last one repeats scenarios), so row i is the same to the last bit for any number of scenarios. Another batch size may
round differently: the usual one depends on how many people there are (`episodes_at_once`).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import cycle, islice

import numpy as np

from jaxwalk.evaluation.continuous import Batch, Played, played
from jaxwalk.evaluation.ghosts import walk_ghosts
from jaxwalk.evaluation.playing import host_driver, play
from jaxwalk.evaluation.unhindered import unhindered_times, with_delay
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.maps import map_labels
from jaxwalk.metrics import Rows, measure
from jaxwalk.platforms import few_launches
from jaxwalk.relief import relieve
from jaxwalk.scenarios import Source
from jaxwalk.sim.environment import Street
from jaxwalk.sim.trajectory import Trajectory, part_of

BATCH = 512
"""Most episodes in a batch, unless another number is asked for."""
FEWEST, PEOPLE = 64, 12 * BATCH
"""Among many people a batch has fewer episodes: about `PEOPLE` people in all, but at least `FEWEST` episodes."""
AT_ONCE = 2
"""Number of lanes, each of which plays as many episodes at once as a batch has: a single one leaves cores idle."""

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
        batch: episodes in a batch (default: `episodes_at_once`). `AT_ONCE` batches are in progress at a time. Memory
            grows with it, about 0.4 MB per episode of 12 people.
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
    batch = _size(batch, street, policies)
    episodes, config = len(source), street.config
    span = range(episodes) if span is None else span
    if span.start % batch or not 0 <= span.start < span.stop <= episodes:
        raise ValueError(f"a span must begin at a multiple of {batch} and lie in [0, {episodes}), not be {span}")
    maps = np.array(map_labels(street.maps), object)
    times = unhindered_times(street)

    def planned(first: int) -> Batch:
        numbers = (first + np.arange(batch)) % episodes
        return Batch(numbers, *source.take(numbers), min(batch, span.stop - first))

    def rows(done: Batch, trajectory: Trajectory) -> Rows:
        frames, asked = len(trajectory.car_x), slice(done.count)
        ghosts = walk_ghosts(street, done.scenarios, done.keys, frames=frames)
        measured = measure(trajectory, part_of(ghosts, frames=frames, episodes=asked), config=config)
        known = with_delay(measured, times, done.scenarios)
        return replace(known, maps=maps[np.asarray(done.scenarios.map)[asked]])

    starts = range(span.start, span.stop, batch)
    count = min(len(starts), 1 if host_driver(policies) else AT_ONCE)  # a host driver plays one batch at a time anyway
    lanes = [played(street, policies, map(planned, starts[first::count])) for first in range(count)]
    for number, done in enumerate(_in_turn(lanes, len(starts)), 1):
        if progress is not None:
            progress(min(number * batch, len(span)), len(span))
        yield rows(*done)
    relieve()


def _in_turn(lanes: Sequence[Iterator[Played]], batches: int) -> Iterator[Played]:
    """Yield that many batches, one of each lane after the other; meanwhile all lanes play on.

    Each lane is asked once more than it has batches; nobody reads the StopIteration.
    """
    with ThreadPoolExecutor(len(lanes)) as pool:
        coming = deque(pool.submit(next, lane) for lane in lanes)
        for lane in islice(cycle(lanes), batches):
            done = coming.popleft().result()
            coming.append(pool.submit(next, lane))
            yield done


def replay(
    street: Street, policies: Roles[Policy], source: Source, numbers: Sequence[int], *, batch: int | None = None
) -> Trajectory:
    """Return the episodes of some scenarios of a source, as `evaluate` plays them with the same ``batch``.

    Raises:
        ValueError: there are no ``numbers`` or more than ``batch``, the source lacks one of them, or ``batch`` is
            below 1.
    """
    batch = _size(batch, street, policies)
    chosen = np.asarray(numbers, np.int64)
    if not 0 < len(chosen) <= batch:
        raise ValueError(f"replay takes 1 to {batch} scenarios at once, not {len(chosen)}")
    full = np.resize(chosen, batch)  # repeated to a full batch, so that nothing is compiled again
    scenarios, keys = source.take(full)
    trajectory = play(street, policies, scenarios, keys, numbers=full)
    count = len(chosen)
    return part_of(trajectory, frames=int(trajectory.length[:count].max()) + 1, episodes=slice(count))


def episodes_at_once(street: Street, policies: Roles[Policy]) -> int:
    """Return the usual size of a batch: a power of two, the smaller the more people there are.

    A CPU computes larger arrays more slowly, presumably as they leave its cache: ``docs/evaluation.md`` has numbers. A
    `HostDriver`, which is called once for a whole batch, and a GPU get `BATCH`.
    """
    if few_launches() or host_driver(policies):
        return BATCH
    fits = max(PEOPLE // max(street.world.rules.pedestrians, 1), FEWEST)
    return min(BATCH, 1 << fits.bit_length() - 1)


def _size(batch: int | None, street: Street, policies: Roles[Policy]) -> int:
    """Return the number of episodes played at once. Raise ValueError if it is below 1."""
    if batch is not None and batch < 1:
        raise ValueError(f"batch must be at least 1, not {batch}")
    return episodes_at_once(street, policies) if batch is None else batch
