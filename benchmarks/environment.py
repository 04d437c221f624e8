"""How many environment steps per second: `python -m benchmarks.environment --help`.

Fresh random actions at every step, restarts on, and every observation set and every reward term of both roles reduced
into the result, so that nothing can be left out. No learning. The processor's cores each play a share of the
environments, as devices of one `shard_map`.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import time
from collections.abc import Callable
from typing import Any


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Environment steps per second, with all observations and rewards.")
    parser.add_argument(
        "--environments", type=int, nargs="+", default=[64, 256, 1024, 1536, 4096, 16384], metavar="N",
        help="environments played at once, in all shards together (default: 64 256 1024 1536 4096 16384)",
    )  # fmt: skip
    parser.add_argument("--shards", type=int, metavar="N", help="devices to share the work (default: one per core)")
    parser.add_argument("--steps", type=int, default=256, help="steps in one call, a multiple of 8 (default: 256)")
    parser.add_argument("--seconds", type=float, default=3.0, help="at least this long for each row (default: 3)")
    parser.add_argument("--seed", type=int, default=0, help="of scenarios and actions (default: 0)")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead of the table")
    options = parser.parse_args()
    options.shards = options.shards or len(os.sched_getaffinity(0))
    for name in ("shards", "steps"):
        if getattr(options, name) < 1:
            parser.error(f"--{name} must be 1 or more")
    for count in options.environments:
        if count < 1 or count % options.shards:
            parser.error(f"--environments {count}: must be a multiple of --shards {options.shards}")
    return options


def everything(street: Any) -> tuple[Callable, Callable]:
    """A policy that acts at random and looks at everything, and what is kept of a step: one number for each street."""
    import jax
    import jax.numpy as jnp

    from jaxwalk.interfaces import ByRole
    from jaxwalk.sim.observation import OBSERVATIONS

    def act(key, scenario, state, memory):
        seen = [street.observe(scenario, state, role, name) for role, sets in OBSERVATIONS.items() for name in sets]
        seen.append(street.global_state(scenario, state))
        words = jnp.moveaxis(jax.random.key_data(key), -1, 0)  # keys are random numbers: 64 fresh bits are enough
        action = jnp.stack([words[0] >> 16, words[0] & 0xFFFF]).astype(jnp.float32) * 2.0**-15 - 1
        go = words[1][None] >> jnp.arange(street.config.pedestrians, dtype=jnp.uint32)[:, None] & 1
        looked = sum(jnp.ones(x[..., 0].size) @ x.reshape(-1, x.shape[-1]) for x in seen)  # a sum, as a product
        return ByRole(action, go.astype(jnp.int32)), memory, looked

    def keep(step):
        terms = [*step.outcome.rewards.driver.values(), *step.outcome.rewards.pedestrian.values()]
        paid = sum(term.astype(jnp.float32).sum(axis=tuple(range(term.ndim - 1))) for term in terms)
        return paid * step.valid, step.record, step.outcome.ended, step.valid

    return act, keep


def benchmark(options: argparse.Namespace) -> dict[str, Any]:
    """Measure every row."""
    import jax
    import numpy as np
    from jax.sharding import Mesh, NamedSharding, PartitionSpec

    from jaxwalk import Street
    from jaxwalk.rollout import TRAINING, environment_keys, rollout, seed_key, start
    from jaxwalk.sim.reward import DRIVER_TERMS, PEDESTRIAN_TERMS

    devices = jax.devices()[: options.shards]
    mesh = Mesh(np.array(devices), ("env",))
    street = Street.create(
        driver_weights=dict.fromkeys(DRIVER_TERMS, 1.0), pedestrian_weights=dict.fromkeys(PEDESTRIAN_TERMS, 1.0)
    )
    act, keep = everything(street)

    def spec(x) -> PartitionSpec:
        return PartitionSpec(*(None,) * (x.ndim - 1), "env") if x.ndim else PartitionSpec()

    def play(environment, stream):
        stream, kept = rollout(environment, act, stream, options.steps, keep=keep)
        return stream, tuple(x.sum(axis=0) for x in kept)

    rows = []
    for count in options.environments:
        keys = environment_keys(seed_key(options.seed, TRAINING), 0, count)
        stream = jax.jit(start)(street, keys)
        shards = jax.tree.map(spec, stream)
        stream = jax.tree.map(lambda x, s: jax.device_put(x, NamedSharding(mesh, s)), stream, shards)
        sharded = jax.jit(
            jax.shard_map(
                play, mesh=mesh, in_specs=(PartitionSpec(), shards), out_specs=(shards, PartitionSpec("env")),
                check_vma=False,
            ),
            donate_argnums=1,
        )  # fmt: skip
        began = time.perf_counter()
        call = sharded.lower(street, stream).compile()
        compiled = time.perf_counter() - began
        for _ in range(max(1, 64 // options.steps)):  # away from the start, where all episodes are in step
            stream, result = call(street, stream)
        jax.block_until_ready(stream)
        times: list[float] = []
        ended = valid = 0
        while sum(times) < options.seconds or len(times) < 3:
            began = time.perf_counter()
            stream, result = jax.block_until_ready(call(street, stream))
            times.append(time.perf_counter() - began)
            assert all(np.isfinite(np.asarray(x)).all() for x in result), "not finite"
            ended += int(result[2].sum())
            valid += int(result[3].sum())
        played = valid / len(times)  # steps in which an ended episode idles until its restart don't count
        rows.append(
            {
                "environments": count,
                "steps_per_second": round(played / statistics.median(times)),
                "best_steps_per_second": round(played / min(times)),
                "valid_share": round(played / (count * options.steps), 4),
                "episodes": ended,
                "compile_seconds": round(compiled, 1),
            }
        )
        if not options.json:
            show(rows[-1], header=len(rows) == 1)
    return {
        "schema": 1,
        "device": devices[0].device_kind,
        "shards": len(devices),
        "cores": len(os.sched_getaffinity(0)),
        "machine": platform.machine(),
        "jax": jax.__version__,
        "steps": options.steps,
        "rows": rows,
        "best_steps_per_second": max(row["steps_per_second"] for row in rows),
    }


def show(row: dict[str, Any], *, header: bool) -> None:
    if header:
        print(f"{'environments':>12} {'steps/s':>12} {'best':>12} {'valid':>7} {'episodes':>9} {'compile [s]':>12}")
    print(
        f"{row['environments']:>12,} {row['steps_per_second']:>12,} {row['best_steps_per_second']:>12,} "
        f"{row['valid_share']:>7.1%} {row['episodes']:>9,} {row['compile_seconds']:>12.1f}",
        flush=True,
    )


def main() -> None:
    options = parse()
    flags = os.environ.get("XLA_FLAGS", "")
    if options.shards > 1 and "host_platform_device_count" not in flags:  # must be set before JAX is imported
        os.environ["XLA_FLAGS"] = f"{flags} --xla_force_host_platform_device_count={options.shards}".strip()
    document = benchmark(options)
    if options.json:
        print(json.dumps(document, indent=2))
    else:
        print(
            f"{document['shards']} shards, {document['device']}: {document['best_steps_per_second']:,} steps/s at best"
        )


if __name__ == "__main__":
    main()
