"""Evaluating a pair of policies on a numbered set of scenarios.

Scenario i of a seed is always the same, and so is what sampling policies draw in it: both depend on the seed and i
alone. All batches have the same size on the device (the last one plays on into scenarios nobody asked for), so row i
does not depend, to the last bit, on how many episodes are asked for. Another batch size may round differently.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import chain
from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int, Key

from jaxwalk.evaluation.game import play
from jaxwalk.evaluation.ghosts import walk_ghosts
from jaxwalk.interfaces import Policy
from jaxwalk.metrics import Rows, measure
from jaxwalk.rollout import EVALUATION, SCENARIO_KEYS, draw_batch, environment_keys, seed_key
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.trajectory import Ghosts, Trajectory

BATCH = 512
"""Episodes played at once, unless told otherwise."""
AT_ONCE = 2
"""Batches under way together: on a processor, much of a batch keeps one core busy."""
HASH_DIGITS = 16
"""Hexadecimal digits of a scenario set's hash."""
SEEDS = 2**31
"""Seeds lie in [0, this)."""

Recorded = TypeVar("Recorded", Trajectory, Ghosts)


def evaluate(
    street: Street,
    driver: Policy,
    pedestrians: Policy,
    *,
    episodes: int,
    seed: int,
    batch: int = BATCH,
    progress: Callable[[int, int], None] | None = None,
) -> Rows:
    """Play scenarios 0 .. ``episodes`` - 1 of a seed and measure them.

    Args:
        street: the world.
        driver: decides for the car.
        pedestrians: decides for all people.
        episodes: how many scenarios; at least 1.
        seed: which set of scenarios; never meets one of a training.
        batch: episodes played at once, twice over; memory grows with it (about 0.4 MB an episode).
        progress: called after every batch with the episodes played so far and ``episodes``.

    Raises:
        ValueError: ``episodes``, ``batch`` or ``seed`` is impossible.
        DriverError: a driver that is not JAX failed.
    """
    batches = evaluate_batches(
        street, driver, pedestrians, episodes=episodes, seed=seed, batch=batch, progress=progress
    )
    return Rows.join(list(batches))


def evaluate_batches(
    street: Street,
    driver: Policy,
    pedestrians: Policy,
    *,
    episodes: int,
    seed: int,
    batch: int = BATCH,
    progress: Callable[[int, int], None] | None = None,
) -> Iterator[Rows]:
    """What `evaluate` joins, batch after batch, each as soon as it is played."""
    _check(episodes, batch, seed)

    def rows(first: int) -> Rows:
        scenarios, keys = draw_scenarios(street, seed=seed, first=first, count=batch)
        trajectory = play(street, driver, pedestrians, scenarios, keys, numbers=first + np.arange(batch))
        frames, asked = len(trajectory.car_x), slice(min(batch, episodes - first))
        ghosts = walk_ghosts(street, scenarios, keys, frames=frames)
        return measure(_some(trajectory, asked, frames), _some(ghosts, asked, frames), config=street.config)

    with ThreadPoolExecutor(AT_ONCE) as pool:
        compiled = rows(0)
        for number, part in enumerate(chain([compiled], pool.map(rows, range(batch, episodes, batch))), 1):
            if progress is not None:
                progress(min(number * batch, episodes), episodes)
            yield part


def replay(
    street: Street, driver: Policy, pedestrians: Policy, *, scenarios: Sequence[int], seed: int, batch: int = BATCH
) -> Trajectory:
    """The episodes of some scenarios of a seed, by their numbers, as `evaluate` plays them with the same ``batch``.

    Raises:
        ValueError: there are no ``scenarios`` or more than ``batch``, one is negative or above 2^30, or ``batch`` or
            ``seed`` is impossible.
    """
    numbers = np.asarray(scenarios, np.int64)
    if not 0 < len(numbers) <= batch:
        raise ValueError(f"replay takes 1 to {batch} scenarios at once, not {len(numbers)}")
    for wrong in numbers[(numbers < 0) | (numbers >= 2**30)][:1]:
        raise ValueError(f"scenario must lie in [0, 2^30), not {wrong}")
    _check(1, batch, seed)
    full = np.resize(numbers, batch)  # repeated to a full batch, so that nothing is compiled twice
    drawn, keys = choose_scenarios(street, seed=seed, numbers=full)
    trajectory = play(street, driver, pedestrians, drawn, keys, numbers=full)
    count = len(numbers)
    return _some(trajectory, slice(count), int(trajectory.length[:count].max()) + 1)


def draw_scenarios(street: Street, *, seed: int, first: int, count: int) -> tuple[Scenario, Key[Array, "episode"]]:
    """Scenarios ``first`` .. ``first + count - 1`` of a seed as a batch, and keys for the policies that play them."""
    environments = environment_keys(seed_key(seed, EVALUATION), first, count)
    return _draw(street, environments), environments


def choose_scenarios(
    street: Street, *, seed: int, numbers: Int[np.ndarray, "episode"]
) -> tuple[Scenario, Key[Array, "episode"]]:
    """Any scenarios of a seed, by their numbers, as `draw_scenarios` draws them one after the other."""
    fold_in = jax.vmap(jax.random.fold_in, in_axes=(None, 0))
    environments = fold_in(seed_key(seed, EVALUATION), jnp.asarray(numbers))
    return _draw(street, environments), environments


def scenario_hash(street: Street, *, seed: int, episodes: int, batch: int = BATCH) -> str:
    """16 hexadecimal digits that stand for the scenario set: SHA-256 over everything chance decides in it.

    Sets that are equal have equal hashes, on every machine and for every ``batch``.
    """
    _check(episodes, batch, seed)
    digest = hashlib.sha256()
    for first in range(0, episodes, batch):
        scenarios, _ = draw_scenarios(street, seed=seed, first=first, count=batch)
        table = np.concatenate([_bytes(x) for x in jax.tree.leaves(scenarios)], axis=1)
        digest.update(table[: episodes - first].tobytes())
    return digest.hexdigest()[:HASH_DIGITS]


def _bytes(array: Array) -> np.ndarray:
    """The little-endian bytes of each episode, ``(episode, byte)``, of an array ``(..., episode)``."""
    episodes = np.asarray(array).T
    flat = np.ascontiguousarray(episodes.reshape(len(episodes), -1))
    return flat.astype(flat.dtype.newbyteorder("<")).view(np.uint8)


def _check(episodes: int, batch: int, seed: int) -> None:
    for name, value in (("episodes", episodes), ("batch", batch)):
        if value < 1:
            raise ValueError(f"{name} must be at least 1, not {value}")
    if not 0 <= seed < SEEDS:
        raise ValueError(f"seed must be 0 or more and below {SEEDS}, not {seed}")


@eqx.filter_jit
def _draw(street: Street, environments: Key[Array, "episode"]) -> Scenario:
    """The scenario with which each environment would begin a rollout."""
    first_episode = jax.vmap(lambda key: jax.random.fold_in(jax.random.fold_in(key, SCENARIO_KEYS), 0))
    return draw_batch(street, first_episode(environments))


def _some(recorded: Recorded, episodes: slice, frames: int) -> Recorded:
    """Some episodes, and the first frames."""

    def cut(name: str, column: np.ndarray) -> np.ndarray:
        return column[:frames, episodes] if name.startswith(_PER_FRAME) else column[episodes]

    return replace(recorded, **{name: cut(name, x) for name, x in vars(recorded).items() if name != "dt"})


_PER_FRAME = (
    "car_", "ped_", "on_", "crossing", "decisions", "at_kerb", "enters_roadway", "going", "predicted_miss",
)  # fmt: skip
"""How the names of columns begin that have a frame axis first."""
