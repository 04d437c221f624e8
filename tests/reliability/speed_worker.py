"""A worker of `speed_against.py`: runs in any checkout since 0.1, whose modules it finds by their names then or now.

It prints `ready` once it is compiled and warm. Then, for each line on standard input, it works for about a second and
prints its environment steps, or evaluated scenarios, per second.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import jax

NAMES = {
    "simulation": ("jaxwalk.bench.simulation", "jaxwalk.experiments.benchmark.simulation"),
    "recipes": ("jaxwalk.recipes", "jaxwalk.experiments.recipes"),
    "street": ("jaxwalk.runs.street", "jaxwalk.experiments.world"),
}
"""Modules by their present name, and by that of 0.1."""
ENVIRONMENTS, STEPS = 1024, 256
SCENARIOS = 1024
VIEWS = (("driver", "paper"), ("driver", "route"), ("pedestrian", "paper"), ("pedestrian", "kerb"))
"""Every view of 0.1 of what a real car can know, with its role: the same work in every checkout."""
WARM = 3
"""Calls before the first turn."""
SECONDS = 1.0
"""Shortest turn."""


def module(name: str):
    """The module, whatever it is called here."""
    now, before = NAMES[name]
    try:
        return import_module(now)
    except ModuleNotFoundError as error:
        if not now.startswith(error.name or "?"):
            raise
        return import_module(before)


def simulator() -> tuple[Callable[[], None], int]:
    """Rollouts with the views of 0.1 and every reward term."""
    from jaxwalk import SimConfig

    simulation = module("simulation")
    street = simulation.paid_street(SimConfig())
    program = simulation.build(street, ENVIRONMENTS, STEPS, 0, VIEWS)
    stream = program.stream

    def work() -> None:
        nonlocal stream
        stream, _ = jax.block_until_ready(program.call(street, stream))

    return work, ENVIRONMENTS * STEPS


def experiment_of(recipe: str):
    """A recipe of 0.1: the same work in every checkout. Of those, only ``fast`` has changed since."""
    if recipe == "fast" and module("recipes").__name__ == NAMES["recipes"][0]:
        sys.path.insert(0, str(Path(__file__).parents[1]))
        return import_module("compat.fast_of_0_1").fast_of_0_1()
    return module("recipes").RECIPES[recipe]


def updates(recipe: str) -> tuple[Callable[[], None], int]:
    """Updates of a recipe at its own size."""
    from jaxwalk.learning import mappo
    from jaxwalk.rollout import TRAINING, seed_key

    street = module("street")
    experiment = street.shared_out(experiment_of(recipe))
    environment, config = street.make_street(experiment), replace(experiment.train, updates=1)
    others = street.fixed_policies(experiment)
    learner = mappo.init(environment, config, seed_key(0, TRAINING), others=others)

    def work() -> None:
        nonlocal learner
        learner, _ = jax.block_until_ready(mappo.update(environment, config, learner))

    return work, experiment.steps_per_update


def evaluation() -> tuple[Callable[[], None], int]:
    """Scenarios played and measured, with the driver that ignores people."""
    from jaxwalk import Street
    from jaxwalk.evaluation import evaluate
    from jaxwalk.policies import AlwaysGo, RouteFollower

    street, driver, people = Street.create(), RouteFollower(), AlwaysGo()
    try:
        from jaxwalk.scenarios import Drawn
    except ModuleNotFoundError:  # 0.1
        return lambda: evaluate(street, driver, people, episodes=SCENARIOS, seed=0), SCENARIOS
    source = Drawn(street, seed=0, count=SCENARIOS)
    return lambda: evaluate(street, {"driver": driver, "pedestrian": people}, source), SCENARIOS


def main() -> None:
    part = sys.argv[1]
    parts = {"simulator": simulator, "evaluation": evaluation}
    work, steps = parts[part]() if part in parts else updates(part)
    for _ in range(WARM):
        work()
    print("ready", flush=True)
    for _ in sys.stdin:
        begun, done = time.perf_counter(), 0
        while time.perf_counter() - begun < SECONDS:
            work()
            done += steps
        print(done / (time.perf_counter() - begun), flush=True)


if __name__ == "__main__":
    main()
