"""The speed of training: whole updates of `jaxwalk.learning.mappo`, and the machine's peak between and after them."""

from __future__ import annotations

import statistics
import time
from dataclasses import replace
from typing import Any

import jax

from jaxwalk.bench.benchmark_settings import Settings
from jaxwalk.bench.machine import accelerated, peak_memory
from jaxwalk.bench.processes import tell
from jaxwalk.bench.products import peak_products
from jaxwalk.interfaces import Environment
from jaxwalk.learning import mappo
from jaxwalk.learning.config import TrainConfig, own_environments
from jaxwalk.learning.flops import network_flops, sizes_of
from jaxwalk.recipes import RECIPES, Experiment, single_agent, with_training
from jaxwalk.rollout import TRAINING, seed_key
from jaxwalk.runs.street import fixed_policies, make_street, shared_out
from jaxwalk.shards import everywhere, mesh_of


def fast(settings: Settings) -> dict[str, Any]:
    """Measure the recipe ``fast`` at its own size, with the car alone, and with other numbers of environments."""
    own = own_size(RECIPES["fast"], settings)
    alone = [] if settings.quick else [single_agent(own)]
    return _measure_all(own, [*alone, *_with_other_sizes(own, settings)], settings)


def paper(settings: Settings) -> dict[str, Any]:
    """Measure the recipe ``paper`` at its own size; on an accelerator also with other numbers of environments."""
    own = own_size(RECIPES["paper"], settings)
    return _measure_all(own, _with_other_sizes(own, settings) if accelerated() else [], settings)


def own_size(experiment: Experiment, settings: Settings) -> Experiment:
    """Return the experiment as it is measured on this machine."""
    changed = with_training(experiment, environments=settings.recipe_environments)
    return with_training(shared_out(replace(changed, seed=settings.seed)), chunk_rows=settings.chunk_rows)


def _with_other_sizes(own: Experiment, settings: Settings) -> list[Experiment]:
    counts = [n for n in settings.training_environments if n != own.train.environments]
    return [shared_out(with_training(own, environments=count, shards=1)) for count in counts]


def _measure_all(own: Experiment, others: list[Experiment], settings: Settings) -> dict[str, Any]:
    """Return a row for each experiment; measure the machine's peak in between and afterwards.

    The memory's peak is that of the first experiment, which has the fresh process to itself.
    """
    rows = [measure(own, settings.seconds) | {"peak_memory_bytes": peak_memory()}]
    products = peak_products(settings.products, settings.seconds)
    if others:
        rows += [measure(experiment, settings.seconds) for experiment in others]
        products += peak_products(settings.products, settings.seconds)
    return {"rows": rows, "products": products}


def measure(experiment: Experiment, seconds: float) -> dict[str, Any]:
    """Measure one row: the median update, the resulting rate, and the networks' operations by formula."""
    street, config = make_street(experiment), experiment.train
    first, times = time_updates(experiment, street, config, seconds)
    update_s = statistics.median(times)
    agents = sizes_of(street, config).agents
    learning = sum(n * own_environments(config, role) / config.environments for role, n in agents.items())
    cost = network_flops(config, sizes_of(street, config))
    rate = experiment.steps_per_update / update_s
    row = {
        "recipe": experiment.recipe,
        "single_agent": experiment.single_agent,
        "environments": config.environments,
        "shards": config.shards,
        "steps": config.steps,
        "chunk_rows": config.chunk_rows,
        "updates": len(times),
        "update_s": update_s,
        "first_update_s": round(first, 2),
        "train_steps_per_s": rate,
        "best_train_steps_per_s": experiment.steps_per_update / min(times),
        "agent_transitions_per_s": rate * learning,
        "flop_per_step": cost.total,
        "flop_per_step_acting": cost.acting,
        "flop_per_step_judging": cost.judging,
        "flop_per_step_fits": dict(cost.fits),
        "flops": rate * cost.total,
    }
    alone = ", the car alone" if experiment.single_agent else ""
    tell(
        f"{experiment.recipe}{alone}, {config.environments:,} x {config.steps}: {rate:,.0f} steps/s, "
        f"{row['flops'] / 1e9:,.1f} GFLOP/s, first update after {first:.1f} s"
    )
    return row


def time_updates(
    experiment: Experiment, street: Environment, config: TrainConfig, seconds: float
) -> tuple[float, list[float]]:
    """Return the time until the first update is made, including compiling, and the time of each later update [s]."""
    begun = time.perf_counter()
    key = seed_key(experiment.seed, TRAINING)
    learner = mappo.init(street, config, key, others=fixed_policies(experiment))
    street = everywhere(street, mesh_of(config.shards))
    learner, metrics = jax.block_until_ready(mappo.update(street, config, learner))
    first = time.perf_counter() - begun
    times: list[float] = []
    while sum(times) < seconds or len(times) < 5:
        begun = time.perf_counter()
        learner, metrics = jax.block_until_ready(mappo.update(street, config, learner))
        times.append(time.perf_counter() - begun)
    if not float(metrics["finite"]):
        raise FloatingPointError(f"{experiment.recipe}: training gave numbers that are not finite")
    return first, times
