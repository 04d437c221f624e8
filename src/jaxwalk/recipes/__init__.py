"""Recipes: complete trainings under a name. A recipe is one file here and one word in `RECIPES`; none imports JAX."""

from jaxwalk.recipes.experiment import LONGEST, Experiment, single_agent, with_training
from jaxwalk.recipes.fast import FAST
from jaxwalk.recipes.paper import PAPER
from jaxwalk.recipes.towns import BLIND_CORNER, TOWN

__all__ = ["BLIND_CORNER", "FAST", "LONGEST", "PAPER", "RECIPES", "TOWN", "Experiment", "single_agent", "with_training"]

RECIPES: dict[str, Experiment] = {experiment.recipe: experiment for experiment in (FAST, PAPER, TOWN, BLIND_CORNER)}
"""The recipes, by name."""
