"""Compiles a rollout and a training update for a GPU that is only described, and counts what they would do there."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jax.experimental import topologies
from jax.sharding import Mesh, SingleDeviceSharding

from jaxwalk.bench.benchmark_settings import Settings
from jaxwalk.bench.machine import describe
from jaxwalk.bench.processes import tell
from jaxwalk.bench.simulation import keep, random_actions
from jaxwalk.bench.thunks import COPIES, LAUNCHES, MICROSECONDS, SYNCHRONISATIONS, Work, by_part, read_work, total
from jaxwalk.bench.training_speed import WHOLE_MINIBATCH
from jaxwalk.learning import mappo
from jaxwalk.learning.config import GLOBAL
from jaxwalk.platforms import traced_for
from jaxwalk.recipes import RECIPES, Experiment, with_training
from jaxwalk.rollout import RESTART_EVERY, TRAINING, Act, environment_keys, rollout, seed_key, start
from jaxwalk.runs.street import fixed_policies, make_street
from jaxwalk.shards import SHARDS
from jaxwalk.sim.environment import Street

WORLDS_OF = ("fast", "town", "blind-corner")
"""Recipes with whose worlds and views programs are compiled: the paper's street first."""
BLOCKS = 8
"""Blocks of steps in a compiled rollout; each begins with restarts."""
OPTIONS = {"xla_gpu_collect_cost_model_stats": True, "xla_backend_optimization_level": 0}
"""Compiler options: XLA's model of times; kernels that are never run needn't be fast, and compile sooner."""


def plan(settings: Settings) -> dict[str, Any]:
    """Return a row for each program, and where it was compiled."""
    device = described_device(str(settings.plan))
    recipes = WORLDS_OF[:1] if settings.quick else WORLDS_OF
    with traced_for("gpu"):
        rows = [rollout_row(RECIPES[recipe], settings.plan_environments, device) for recipe in recipes]
        rows += [] if settings.quick else [update_row(RECIPES[recipe], device) for recipe in recipes]
    return describe(settings) | {"device": device.device_kind, "programs": rows}


def described_device(name: str) -> Any:
    """Return a GPU of which only the description is here: the file ``NAME.txtpb`` beside this module."""
    text = files("jaxwalk.bench").joinpath(f"{name}.txtpb").read_text(encoding="utf-8")
    (device,) = topologies.get_topology_desc(platform="cuda", target_config=text, topology="1x1x1").devices
    return device


def rollout_row(experiment: Experiment, count: int, device: Any) -> dict[str, Any]:
    """Compile a rollout with a recipe's world and views and random actions; return what it does."""
    street, steps = make_street(experiment), BLOCKS * RESTART_EVERY
    act = look_and_record(street, views_of(experiment))
    keys = jax.eval_shape(lambda: environment_keys(seed_key(0, TRAINING), 0, count))
    stream = jax.eval_shape(start, street, keys)

    def play(street: Street, stream: Any) -> Any:
        return rollout(street, act, stream, steps, keep=keep)

    compiled = compile_for(device, play, street, stream, donate=1)
    return _row("rollout", experiment, count, steps, compiled)


def update_row(experiment: Experiment, device: Any) -> dict[str, Any]:
    """Compile a recipe's training update, of its own size on one device; return what it does."""
    experiment = with_training(experiment, shards=1, chunk_rows=WHOLE_MINIBATCH)
    street, config = make_street(experiment), experiment.train
    learner = mappo.init(street, config, seed_key(0, TRAINING), others=fixed_policies(experiment))
    mesh = Mesh(np.array([device]), (SHARDS,))

    def update(street: Street, learner: Any) -> Any:
        return eqx.filter(mappo.update_on(mesh, street, config, learner), eqx.is_array)

    compiled = compile_for(device, update, street, learner)
    return _row("update", experiment, config.environments, config.steps, compiled)


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
    """A program compiled for a described device."""

    work: Work
    memory_bytes: int
    """Inputs, outputs and what it holds besides, each counted once [B]."""
    compile_s: float


def compile_for(device: Any, function: Callable[..., Any], *trees: Any, donate: int | None = None) -> Compiled:
    """Compile a function of pytrees, whose arrays may be shapes alone, for a device; return what it does in a call."""
    where = SingleDeviceSharding(device)
    arrays, rest = eqx.partition(trees, lambda x: hasattr(x, "dtype"))
    shapes = jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=where), arrays)

    def call(*arrays: Any) -> Any:
        return function(*eqx.combine(arrays, rest))

    with tempfile.TemporaryDirectory(prefix="jaxwalk-plan-") as folder:
        begun = time.perf_counter()
        lowered = jax.jit(call, donate_argnums=() if donate is None else donate).lower(*shapes)
        compiled = lowered.compile(OPTIONS | {"xla_dump_to": folder})
        seconds = time.perf_counter() - begun
        used: Any = compiled.memory_analysis()
        sizes = used.argument_size_in_bytes + used.output_size_in_bytes + used.temp_size_in_bytes
        return Compiled(read_work(Path(folder)), sizes - used.alias_size_in_bytes, seconds)


def _row(program: str, experiment: Experiment, count: int, steps: int, compiled: Compiled) -> dict[str, Any]:
    """Return a row of a program; amounts are for each step of all environments together."""
    each = {name: total(compiled.work, name) / steps for name in (LAUNCHES, COPIES, SYNCHRONISATIONS, MICROSECONDS)}
    tell(
        f"{program}, {experiment.recipe}: {each[LAUNCHES]:.1f} launches a step, compiled in {compiled.compile_s:.0f} s"
    )
    return {
        "program": program,
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
