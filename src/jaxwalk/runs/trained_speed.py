"""How fast the car was in which a driver was trained: beyond that, tests ask for what it never met."""

from __future__ import annotations

from pathlib import Path

from jaxwalk.policies import read_metadata
from jaxwalk.policies.policy_names import RULES, is_host_driver
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.contestant_names import policy_file
from jaxwalk.runs.folder import Run


def trained_speed(name: str) -> float | None:
    """Return the car's top speed in the training of a driver that `contestant` accepts [m/s].

    None for rules, for drivers that aren't written in JAX, and for files whose recipe isn't known.
    """
    bare, _ = unshielded("driver", name)
    if bare in RULES["driver"] or is_host_driver(bare):
        return None
    if Path(bare).is_dir():
        return Run.open(bare).experiment.sim.max_speed
    recipe = read_metadata(policy_file("driver", bare)).get("recipe")
    return RECIPES[recipe].sim.max_speed if recipe in RECIPES else None
