"""What does a car cost beside its reward? Contacts, the speed in them, and how long one is near, per episode."""

import sys
from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk import DRIVERS, POPULATIONS, Drawn, Street
from jaxwalk.acting import act, cast_of, fresh_memory, step_key
from jaxwalk.policies import load_policy, shipped_policy
from jaxwalk.sim.cost import DRIVER_COSTS
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.sim.suites import SUITES

episodes, seed = (int(x) for x in sys.argv[1:] or (32, 0))  # use 256 or more for reliable numbers
suite = SUITES["blind-corner"]
rules = replace(WORLDS["blind-corner"], pedestrians=suite.people)
street = Street.create(suite.maps, rules, driver_costs=tuple(DRIVER_COSTS))
scenarios, keys = Drawn(street, seed, episodes).take(np.arange(episodes))


@eqx.filter_jit
def costs(policies):
    """Return the sum of each cost over each episode."""
    cast = cast_of(policies)

    def step(played, number):
        state, memory, ended = played
        acted = act(street, cast, step_key(keys, number), scenarios, state, memory)
        state, outcome = street.step(scenarios, state, acted.actions)
        counted = {name: jnp.where(ended, 0, cost) for name, cost in outcome.costs["driver"].items()}
        return (state, acted.memory, ended | outcome.ended), counted

    begin = street.reset(scenarios), fresh_memory(street, cast, (episodes,)), jnp.zeros(episodes, bool)
    _, counted = jax.lax.scan(step, begin, jnp.arange(rules.horizon))
    return {name: cost.sum(axis=0) for name, cost in counted.items()}


learned = load_policy(shipped_policy("driver", "single-agent"), "driver")
for name, driver in {"route-follower": DRIVERS["route-follower"](), "single-agent": learned}.items():
    found = costs({"driver": driver, "pedestrian": POPULATIONS["always-go"]()})
    print(f"{name}: " + ", ".join(f"{cost} {float(found[cost].mean()):.4f}" for cost in DRIVER_COSTS))
