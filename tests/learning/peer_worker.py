"""One of several processes that play a small game: `python peer_worker.py PROCESS PROCESSES SHARDS PORT FOLDER`.

Makes three updates, saves them as a checkpoint, reads that again, makes a fourth one, and writes every array. A process
writes what it holds: all of them must be the same.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import equinox as eqx
import jax
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))


def arrays_of(learner):
    """Every array by its place, keys as numbers."""
    leaves = jax.tree_util.tree_leaves_with_path(eqx.filter(learner, eqx.is_array))
    return {jax.tree_util.keystr(at): np.asarray(_data(x)) for at, x in leaves}


def _data(x):
    return jax.random.key_data(x) if jax.dtypes.issubdtype(x.dtype, jax.dtypes.prng_key) else x


def play(shards, folder):
    """The arrays after the first update and after the last one."""
    from jaxwalk.learning.checkpoint import restore, save
    from jaxwalk.learning.config import RoleConfig, TrainConfig
    from jaxwalk.learning.mappo import init, update
    from jaxwalk.peers import ask, gathered, is_first, wait_for_all
    from learning import games

    role = RoleConfig(actor_hidden=(16,), critic_hidden=(16,), entropy=0.003)
    config = TrainConfig(
        roles={"driver": role, "pedestrian": replace(role, epochs=2)}, environments=32, steps=16, minibatches=4,
        updates=4, learning_rate=5e-3, discount=0.9, shared_critic_hidden=(16,), chunk_rows=64, shards=shards,
    )  # fmt: skip
    game = games.game("bandit", length=3)
    learner, _ = update(game, config, init(game, config, jax.random.key(0)))
    first = arrays_of(gathered(learner))
    for _ in range(2):
        learner, metrics = update(game, config, learner)
    kept = gathered(learner)
    if is_first():
        save(folder, kept, updates=3)
    own = jax.process_index()
    assert ask(lambda: [own, -own])() == [jax.process_count() - 1, 0]
    wait_for_all()
    learner = restore(folder, init(game, config, jax.random.key(7)))
    learner, metrics = update(game, config, learner)
    numbers = {name: np.asarray(value) for name, value in metrics.items()}
    return first, arrays_of(gathered(learner)) | numbers


if __name__ == "__main__":
    process, processes, shards = map(int, sys.argv[1:4])
    jax.config.update("jax_num_cpu_devices", shards // processes)
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    if processes > 1:
        jax.distributed.initialize(
            f"127.0.0.1:{sys.argv[4]}", processes, process, cluster_detection_method="deactivate"
        )
    out = Path(sys.argv[5])
    for name, arrays in zip(("first", "last"), play(shards, out / "checkpoints"), strict=True):
        np.savez(out / f"{name}-{process}.npz", **arrays)
