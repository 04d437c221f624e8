"""The speed of the simulator alone: random actions at every step, restarts, and all observations and rewards.

Every observation set is computed, except those of what a real car can't know or only infers, and every reward term
of both roles. All of it is reduced into the result, so that the compiler can't leave anything out. There is no
learning. Each processor core plays a share of the environments, as a device of one `shard_map`, part by part.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import PartitionSpec

from jaxwalk.bench.benchmark_settings import Settings
from jaxwalk.bench.processes import tell
from jaxwalk.rollout import TRAINING, Act, Step, Stream, environment_keys, rollout, seed_key, start
from jaxwalk.shards import EVERYWHERE, SHARDS, by_environment, everywhere, mesh_of, place
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import INFERRED, OBSERVATIONS, PRIVILEGED_SETS
from jaxwalk.sim.reward import DRIVER_TERMS, PEDESTRIAN_TERMS
from jaxwalk.sim.sim_config import SimConfig

Sets = tuple[tuple[str, str], ...]
"""Observation sets, each with its role."""
EVERY: Sets = tuple(
    (role, name) for role, sets in OBSERVATIONS.items() for name in sets if name not in PRIVILEGED_SETS | INFERRED
)
"""All sets except those of what is hidden from a real car, and of what it could only infer."""
PAPER: Sets = tuple((role, "paper") for role in OBSERVATIONS)
"""The sets that the published environment computes."""
PART = 2048
"""Largest number of environments that a processor core plays at a time, so that their data stay in its cache."""
WARM_STEPS = 64
"""Steps before timing starts, so that episodes are no longer at the same step."""


def over_environments(settings: Settings) -> list[dict[str, Any]]:
    """Return a row for each number of environments; one more for the fastest, with the paper's observations alone."""
    street = paid_street(SimConfig())
    rows = [measure(street, count, settings) for count in settings.environments]
    best = max(rows, key=lambda row: row["env_steps_per_s"])
    return [*rows, measure(street, best["environments"], settings, sets=PAPER)]


def over_pedestrians(settings: Settings) -> list[dict[str, Any]]:
    """Return a row for each number of pedestrians."""
    return [
        measure(paid_street(SimConfig(pedestrians=count)), settings.crowd_environments, settings)
        for count in settings.pedestrians
    ]


def paid_street(config: SimConfig, maps: Sequence[str] = ("paper",)) -> Street:
    """Return a street with every reward term."""
    return Street.create(
        maps,
        config,
        driver_weights=dict.fromkeys(DRIVER_TERMS, 1.0),
        pedestrian_weights=dict.fromkeys(PEDESTRIAN_TERMS, 1.0),
    )


def measure(street: Street, count: int, settings: Settings, sets: Sets = EVERY) -> dict[str, Any]:
    """Measure one row: the rate, the memory, and the conditions of the measurement."""
    program = build(street, count, settings.steps, settings.seed, sets)
    timing = play(program, settings)
    row = {
        "environments": count,
        "observations": "paper" if sets == PAPER else "every",
        "pedestrians": street.world.rules.pedestrians,
        "shards": program.shards,
        "steps": settings.steps,
        **timing,
        "compile_s": round(program.compile_s, 2),
        "temporary_bytes": program.temporary_bytes,
        "state_bytes": program.state_bytes,
        "kept_bytes": program.kept_bytes,
    }
    size = f"{count:>6,} environments, {street.world.rules.pedestrians:>2} pedestrians"
    tell(
        f"{size}, observations: {row['observations']:<5} {row['env_steps_per_s']:>10,} steps/s, "
        f"{program.temporary_bytes / 1e6:,.1f} MB, compiled in {program.compile_s:.1f} s"
    )
    return row


@dataclass
class Program:
    """A compiled rollout, and the memory that it takes."""

    call: Callable[[Street, Stream], tuple[Stream, Any]]
    street: Street
    """On every device, as a training has it."""
    stream: Stream
    shards: int
    compile_s: float
    """Time to compile, unless the program was found in the cache of compiled code [s]."""
    temporary_bytes: int
    """Memory that all shards together use while it runs, besides inputs and outputs [B]."""
    state_bytes: int
    """Size of the inputs: scenarios, states and keys [B]."""
    kept_bytes: int
    """Size of what the rollout keeps of every step [B]."""

    def play(self) -> Any:
        """Go on for as many steps as were compiled; return the sums of what is kept."""
        self.stream, result = jax.block_until_ready(self.call(self.street, self.stream))
        return result


def build(street: Street, count: int, steps: int, seed: int, sets: Sets = EVERY) -> Program:
    """Compile a rollout of ``count`` environments, shared out among as many devices as divide them evenly."""
    shards = max(n for n in range(1, len(jax.devices()) + 1) if count % n == 0)
    mesh = mesh_of(shards)
    share = count // shards
    least = -(-share // PART) if jax.devices()[0].platform == "cpu" else 1
    parts = next((n for n in range(least, 2 * least) if share % n == 0), 1)

    def play(street: Street, stream: Stream) -> tuple[Stream, Any]:
        def play_part(stream: Stream) -> tuple[Stream, Any]:
            stream, kept = rollout(street, look_and_act(street, sets), stream, steps, keep=keep)
            return stream, tuple(x.sum(axis=0) for x in kept)

        return in_parts(play_part, stream, parts)

    stream = jax.jit(start)(street, environment_keys(seed_key(seed, TRAINING), 0, count))
    where = by_environment(stream)
    stream, street = place(stream, where, mesh), everywhere(street, mesh)
    shared = jax.shard_map(
        play, mesh=mesh, in_specs=(EVERYWHERE, where), out_specs=(where, PartitionSpec(SHARDS)), check_vma=False
    )
    begun = time.perf_counter()
    call = jax.jit(shared, donate_argnums=1).lower(street, stream).compile()
    compile_s = time.perf_counter() - begun
    act = look_and_act(street, sets)
    kept = jax.eval_shape(lambda stream: rollout(street, act, stream, steps, keep=keep)[1], stream)
    used: Any = call.memory_analysis()
    temporary = shards * used.temp_size_in_bytes
    return Program(call, street, stream, shards, compile_s, temporary, _bytes(stream), _bytes(kept))


def in_parts(play: Callable[[Stream], tuple[Stream, Any]], stream: Stream, parts: int) -> tuple[Stream, Any]:
    """Call ``play`` for ``parts`` equal parts of the environments, one after the other."""

    def split(x: jax.Array) -> jax.Array:
        if x.ndim == 0:  # the step number, which all parts share
            return jnp.broadcast_to(x, parts)
        return jnp.moveaxis(x.reshape(*x.shape[:-1], parts, -1), -2, 0)

    def join(x: jax.Array) -> jax.Array:
        return x[0] if x.ndim == 1 else jnp.moveaxis(x, 0, -2).reshape(*x.shape[1:-1], -1)

    return jax.tree.map(join, jax.lax.map(play, jax.tree.map(split, stream))) if parts > 1 else play(stream)


def play(program: Program, settings: Settings) -> dict[str, Any]:
    """Return the median and the best rate; steps in which an ended episode waits for its restart don't count."""
    for _ in range(max(1, WARM_STEPS // settings.steps)):
        program.play()
    times: list[float] = []
    ended = valid = steps = 0
    while sum(times) < settings.seconds or len(times) < 3:
        begun = time.perf_counter()
        result = program.play()
        times.append(time.perf_counter() - begun)
        if not all(np.isfinite(np.asarray(x)).all() for x in result):
            raise FloatingPointError("the simulator gave numbers that are not finite")
        steps += result[3].size * settings.steps
        ended += int(result[2].sum())
        valid += int(result[3].sum())
    played = valid / len(times)
    return {
        "env_steps_per_s": round(played / statistics.median(times)),
        "best_env_steps_per_s": round(played / min(times)),
        "valid_share": round(valid / steps, 4),
        "episodes": ended,
    }


def look_and_act(street: Street, sets: Sets = EVERY) -> Act:
    """Return a policy that acts at random and observes all of those sets; it records one number for each street."""

    def act(key: jax.Array, scenario: Any, state: Any, memory: Any) -> tuple[dict[str, jax.Array], Any, jax.Array]:
        seen = [street.observe(scenario, state, street.view(role, name)) for role, name in sets]
        seen.append(street.global_state(scenario, state))
        looked = sum(jnp.ones(x[..., 0].size) @ x.reshape(-1, x.shape[-1]) for x in seen)  # a sum, as a product
        return random_actions(street, key), memory, jnp.asarray(looked)

    return act


def random_actions(street: Street, key: jax.Array) -> dict[str, jax.Array]:
    """Return everybody's action from a step's keys ``(env,)``, whose 64 bits are random enough."""
    people = jnp.arange(street.world.rules.pedestrians, dtype=jnp.uint32)
    words = jnp.moveaxis(jax.random.key_data(key), -1, 0)
    action = jnp.stack([words[0] >> 16, words[0] & 0xFFFF]).astype(jnp.float32) * 2.0**-15 - 1
    go = words[1][None] >> people[:, None] % 32 & 1
    return {"driver": action, "pedestrian": go.astype(jnp.int32)}


def keep(step: Step) -> tuple[jax.Array, Any, jax.Array, jax.Array]:
    """Return for each street the sum of rewards, the record, whether the episode ended, whether the step counts."""
    terms = [term for terms in step.outcome.rewards.values() for term in terms.values()]
    paid = sum(term.astype(jnp.float32).sum(axis=tuple(range(term.ndim - 1))) for term in terms)
    return jnp.asarray(paid * step.valid), step.record, step.outcome.ended, step.valid


def _bytes(tree: Any) -> int:
    """Return the size of all arrays; a key is two 32-bit words."""
    return sum(
        x.size * (8 if jnp.issubdtype(x.dtype, jax.dtypes.prng_key) else x.dtype.itemsize)
        for x in jax.tree.leaves(tree)
    )
