"""How options are declared: the default in words, what the value is called, and types that commands share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import tyro

from jaxwalk.policies.shield_names import SHIELD_NAMES
from jaxwalk.recipes import RECIPES
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.sim.suites import SUITES

Flag = tyro.conf.FlagCreatePairsOff[bool]
"""An option without a value."""
Acting = Literal["mode", "sample"]
"""How a learned policy chooses its actions."""

if TYPE_CHECKING:
    Recipe = PaperRecipe = ShieldName = Suite = World = str
else:
    Recipe = Literal[tuple(RECIPES)]
    PaperRecipe = Literal[tuple(name for name, recipe in RECIPES.items() if recipe.maps == ("paper",))]
    ShieldName = Literal[SHIELD_NAMES]
    Suite = Literal[tuple(SUITES)]
    World = Literal[tuple(WORLDS)]
"""The name of a recipe, that of one on the paper's street, that of a shield, that of a suite, and that of a world."""


def option(default: str, kind: str | None = None, name: str | None = None) -> Any:
    """Return how ``--help`` shows an option: its default in words, and what its value is called."""
    return tyro.conf.arg(help_behavior_hint=f"(default: {default})", metavar=kind, name=name)


def tuned(name: str, kind: str) -> Any:
    """Return how ``--help`` shows an option that is a field of `TrainConfig`: its default is the recipe's."""
    values = {recipe: f"{getattr(experiment.train, name):g}" for recipe, experiment in RECIPES.items()}
    usual = next(iter(values.values()))
    others = (f"{recipe} {value}" for recipe, value in values.items() if value != usual)
    return option(f"the recipe's: {', '.join((usual, *others))}", kind)
