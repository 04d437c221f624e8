"""Compiles rollouts and training updates for a GPU, and counts what they do there.

The GPU is only described, or it is this machine's own; then they run on it, too.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import jax
import numpy as np
from jax.experimental import topologies
from jax.sharding import Mesh, SingleDeviceSharding

from jaxwalk.bench.benchmark_settings import HERE, Settings
from jaxwalk.bench.machine import describe
from jaxwalk.bench.processes import tell
from jaxwalk.bench.simulation import keep, random_actions
from jaxwalk.bench.thunks import COPIES, LAUNCHES, MICROSECONDS, SYNCHRONISATIONS, Work, by_part, read_work, total
from jaxwalk.learning import mappo
from jaxwalk.learning.config import GLOBAL, WHOLE_MINIBATCH
from jaxwalk.learning.hyperparameters import hyperparameters
from jaxwalk.platforms import traced_for
from jaxwalk.provenance import cores
from jaxwalk.recipes import RECIPES, Experiment, with_training
from jaxwalk.rollout import RESTART_EVERY, TRAINING, Act, environment_keys, rollout, seed_key, start
from jaxwalk.runs.street import fixed_policies, make_street
from jaxwalk.shards import SHARDS
from jaxwalk.sim.environment import Street

WORLDS_OF = ("fast", "town", "blind-corner")
"""Recipes with whose worlds and views programs are compiled: the paper's street first."""
BLOCKS = 8
"""Blocks of steps in a compiled rollout; each begins with restarts."""
COSTS = {"xla_gpu_collect_cost_model_stats": True}
"""Compiler options: XLA's model of times."""
NEVER_RUN = {"xla_backend_optimization_level": 0}
"""Compiler options for kernels that are never run: they needn't be fast, and compile sooner."""
CALLS = 5
"""Fewest calls of a program that are timed, after a first one."""


class Target(NamedTuple):
    """The GPU for which programs are compiled."""

    device: Any
    here: bool
    """Whether it is in this machine, and not only described."""
    seconds: float
    """Time for which each is measured there [s]."""


class Planned(NamedTuple):
    """A program, before it is compiled."""

    name: str
    experiment: Experiment
    environments: int
    steps: int
    """Steps of all environments in a call."""
    call: Callable[[Any, Any], tuple[Any, Any]]
    """Goes on from a state on a street: (state, street) -> (state, result)."""
    state: Any
    """At the beginning; shapes alone where the GPU isn't there."""
    street: Street


def plan(settings: Settings) -> dict[str, Any]:
    """Return a row for each program, and where it was compiled. On a GPU of this machine each is timed, too."""
    here = settings.plan == HERE
    device = jax.devices()[0] if here else described_device(str(settings.plan))
    target = Target(device, here, settings.seconds)
    counts = settings.environments if here else (settings.plan_environments,)
    recipes = WORLDS_OF[:1] if settings.quick else WORLDS_OF
    jobs = [partial(rollout_of, RECIPES[recipe], count, target) for recipe in recipes for count in counts]
    jobs += [] if settings.quick else [partial(update_of, RECIPES[recipe], target) for recipe in (*recipes, "paper")]
    with traced_for("gpu"), ThreadPoolExecutor(cores()) as pool:
        compiled = list(pool.map(partial(compile_for, target), jobs))  # all of them, before any is timed
        rows = [_row(each, target) for each in compiled]
    return describe(settings) | {"device": target.device.device_kind, "programs": rows}


def described_device(name: str) -> Any:
    """Return a GPU of which only the description is here: the file ``NAME.txtpb`` beside this module."""
    text = files("jaxwalk.bench").joinpath(f"{name}.txtpb").read_text(encoding="utf-8")
    (device,) = topologies.get_topology_desc(platform="cuda", target_config=text, topology="1x1x1").devices
    return device


def rollout_of(experiment: Experiment, count: int, target: Target) -> Planned:
    """Return a rollout with a recipe's world and views and random actions."""
    street, steps = make_street(experiment), BLOCKS * RESTART_EVERY
    act = look_and_record(street, views_of(experiment))

    def keys() -> jax.Array:
        return environment_keys(seed_key(0, TRAINING), 0, count)

    if target.here:
        stream = jax.jit(start)(street, jax.jit(keys)())
    else:
        stream = jax.eval_shape(start, street, jax.eval_shape(keys))

    def play(stream: Any, street: Street) -> Any:
        return rollout(street, act, stream, steps, keep=keep)

    return Planned("rollout", experiment, count, steps, play, stream, street)


def update_of(experiment: Experiment, target: Target) -> Planned:
    """Return a recipe's training update, of its own size on one device."""
    experiment = with_training(experiment, shards=1, chunk_rows=WHOLE_MINIBATCH)
    street, config = make_street(experiment), experiment.train
    learner = mappo.init(street, config, seed_key(0, TRAINING), others=fixed_policies(experiment))
    mesh = Mesh(np.array([target.device]), (SHARDS,))

    def update(state: Any, street: Street) -> Any:
        learner, numbers = state
        learner, metrics = mappo.update_on(mesh, street, config, numbers, learner)
        return (learner, numbers), metrics

    state = (learner, hyperparameters(config))
    return Planned("update", experiment, config.environments, config.steps, update, state, street)


def views_of(experiment: Experiment) -> tuple[tuple[str, str], ...]:
    """Return role and name of each view that a recipe's actors and critics read, but for the global state."""
    roles = experiment.train.roles
    names = {role: dict.fromkeys((config.observes, *config.critic_observes)) for role, config in roles.items()}
    return tuple((role, name) for role, shown in names.items() for name in shown if name != GLOBAL)


def look_and_record(street: Street, views: tuple[tuple[str, str], ...]) -> Act:
    """Return a policy that acts at random and records these views, as a training does."""

    def act(key: jax.Array, scenario: Any, state: Any, memory: Any) -> tuple[Any, Any, Any]:
        seen = [street.observe(scenario, state, street.view(role, name)) for role, name in views]
        return random_actions(street, key), memory, seen

    return act


@dataclass
class Compiled:
    """A program compiled for a GPU."""

    program: Planned
    call: Any
    arrays: Any
    """Its state and street on the GPU; shapes alone where it isn't there."""
    work: Work
    memory_bytes: int
    """Inputs, outputs and what it holds besides, each counted once [B]."""
    compile_s: float


def compile_for(target: Target, make: Callable[[], Planned]) -> Compiled:
    """Compile a program, and read what it does in a call."""
    program = make()
    where = SingleDeviceSharding(target.device)
    arrays, rest = eqx.partition((program.state, program.street), lambda x: hasattr(x, "dtype"))
    shapes = jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=where), arrays)

    def call(*arrays: Any) -> Any:
        return eqx.filter(program.call(*eqx.combine(arrays, rest)), eqx.is_array)

    with tempfile.TemporaryDirectory(prefix="jaxwalk-plan-") as folder:
        begun = time.perf_counter()
        options: dict[str, Any] = COSTS | ({} if target.here else NEVER_RUN) | {"xla_dump_to": folder}
        compiled = jax.jit(call, donate_argnums=0).lower(*shapes).compile(options)
        seconds = time.perf_counter() - begun
        work = read_work(Path(folder))
    tell(f"{program.name}, {program.experiment.recipe}, {program.environments:,} environments: compiled")
    used: Any = compiled.memory_analysis()
    sizes = used.argument_size_in_bytes + used.output_size_in_bytes + used.temp_size_in_bytes
    return Compiled(program, compiled, arrays, work, sizes - used.alias_size_in_bytes, seconds)


def call_time(call: Callable[..., Any], arrays: tuple[Any, Any], seconds: float) -> float:
    """Return the median time of a call, each of which goes on from the one before, after a first one [s]."""
    state, street = arrays
    state, _ = jax.block_until_ready(call(state, street))
    times: list[float] = []
    while sum(times) < seconds or len(times) < CALLS:
        begun = time.perf_counter()
        state, _ = jax.block_until_ready(call(state, street))
        times.append(time.perf_counter() - begun)
    return statistics.median(times)


def _row(compiled: Compiled, target: Target) -> dict[str, Any]:
    """Return a row of a program; amounts are for each step of all environments together."""
    program = compiled.program
    steps, count, experiment = program.steps, program.environments, program.experiment
    each = {name: total(compiled.work, name) / steps for name in (LAUNCHES, COPIES, SYNCHRONISATIONS, MICROSECONDS)}
    row = {
        "program": program.name,
        "recipe": experiment.recipe,
        "environments": count,
        "pedestrians": experiment.sim.pedestrians,
        "steps": steps,
        **{f"{name}_per_step": amount for name, amount in each.items()},
        "launches_by_part": {x: amount / steps for x, amount in by_part(compiled.work, LAUNCHES).items()},
        "microseconds_by_part": {x: amount / steps for x, amount in by_part(compiled.work, MICROSECONDS).items()},
        "memory_bytes": compiled.memory_bytes,
        "compile_s": round(compiled.compile_s, 1),
    }
    if target.here:
        arrays = jax.device_put(compiled.arrays, target.device)
        row["measured_steps_per_s"] = round(count * steps / call_time(compiled.call, arrays, target.seconds))
        tell(f"{program.name}, {experiment.recipe}, {count:,} environments: {row['measured_steps_per_s']:,} steps/s")
    return row
