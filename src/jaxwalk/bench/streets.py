"""The cost of many streets: simulations on few and on many, and a training on many beside one on a single street."""

from __future__ import annotations

import time
from itertools import product
from typing import Any

import jax

from jaxwalk.bench.benchmark_settings import Settings
from jaxwalk.bench.in_turns import Turn, playing, take_turns
from jaxwalk.bench.simulation import EVERY, paid_street
from jaxwalk.bench.training_speed import own_size
from jaxwalk.learning.turns import init_in_turns, update_in_turns
from jaxwalk.recipes import RECIPES
from jaxwalk.rollout import TRAINING, seed_key
from jaxwalk.runs.street import crowded, fixed_policies, make_street, on_devices
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import WORLDS

RECIPES_IN_TURNS = ("fast", "town")
"""The recipes whose speeds are compared."""
SEEN = {"every": EVERY, "no rays": tuple(one for one in EVERY if one[1] != "surroundings")}
"""The observation sets that a simulation computes, by what the row is called."""
UPDATES = 4
"""Updates of a training in a turn: recipe ``town`` has four crowds."""


def simulated(settings: Settings) -> list[dict[str, Any]]:
    """Return a row for each number of streets: the speed of the simulator alone in each turn, and the tables' size.

    There are rows with every observation, and with those that don't look for the road's edge along rays, which reads
    more of the tables than all else does.
    """
    streets = {n: paid_street(WORLDS["town"], (f"training:{n}",)) for n in settings.streets}
    cases = {f"{n} streets, observations: {seen}": (n, seen) for seen, n in product(SEEN, streets)}
    programs = {
        name: playing(streets[n], settings.street_environments, settings, SEEN[seen])
        for name, (n, seen) in cases.items()
    }
    turns = take_turns(programs, settings.turns)
    return [
        {
            "observations": seen,
            "streets": n,
            "environments": settings.street_environments,
            "env_steps_per_s": turns[name],
            "bytes_per_street": bytes_per_street(streets[n]),
        }
        for name, (n, seen) in cases.items()
    ]


def trained(settings: Settings) -> list[dict[str, Any]]:
    """Return a row for each recipe: the speed of training in each turn, of updates as `jaxwalk train` makes them."""
    turns = take_turns({name: _learning(name, settings) for name in RECIPES_IN_TURNS}, settings.turns)
    return [{"recipe": name, "train_steps_per_s": turns[name]} for name in RECIPES_IN_TURNS]


def bytes_per_street(street: Street) -> float:
    """Return the memory that the tables of a street take [B]: what all have, over the number of stacked maps."""
    arrays = jax.tree.leaves((street.world.maps, street.world.tables))
    return sum(x.nbytes for x in arrays) / len(street.world.maps.route_count)


def _learning(recipe: str, settings: Settings) -> Turn:
    experiment = own_size(RECIPES[recipe], settings)
    street = make_street(experiment)
    key, others = seed_key(experiment.seed, TRAINING), fixed_policies(experiment)
    learner = init_in_turns(crowded(street, experiment), experiment.train, key, others=others)
    streets = on_devices(street, experiment)

    def turn() -> float:
        nonlocal learner
        begun = time.perf_counter()
        for number in range(UPDATES):
            learner, _ = jax.block_until_ready(update_in_turns(streets, experiment.train, learner, number))
        return UPDATES * experiment.steps_per_update / (time.perf_counter() - begun)

    return turn
