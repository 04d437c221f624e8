"""The recipe ``fast`` of version 0.1, made of today's."""

from __future__ import annotations

from dataclasses import replace

from jaxwalk.learning.config import GLOBAL
from jaxwalk.recipes import RECIPES, Experiment, with_training
from jaxwalk.sim.sim_config import WORLDS


def fast_of_0_1() -> Experiment:
    """Return the recipe ``fast`` as it was: a collision was a disc's, and so were predictions."""
    fast = RECIPES["fast"]
    driver = replace(fast.train.roles["driver"], observes="route", critic_observes=("route", GLOBAL))
    weights = fast.driver_weights | {"closeness": -1.0, "collision": -100.0, "time": -0.02}
    people = replace(fast.train.roles["pedestrian"], fixed=1 / 3)
    roles = fast.train.roles | {"driver": driver, "pedestrian": people}
    return replace(with_training(fast, roles=roles, discount=0.995), sim=WORLDS["paper"], driver_weights=weights)
