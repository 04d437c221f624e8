"""Recipes: complete trainings under a name. A recipe is one file here and one word in `RECIPES`; none imports JAX."""

from jaxwalk.recipes.blind_corner_cvar import BLIND_CORNER_CVAR
from jaxwalk.recipes.blind_corner_lagrangian import BLIND_CORNER_LAGRANGIAN
from jaxwalk.recipes.experiment import LONGEST, Experiment, single_agent, with_limits, with_training
from jaxwalk.recipes.experiment_file import ExperimentFileError, load_experiment
from jaxwalk.recipes.fast import FAST
from jaxwalk.recipes.paper import PAPER
from jaxwalk.recipes.towns import BLIND_CORNER, TOWN

__all__ = [
    "BLIND_CORNER",
    "BLIND_CORNER_CVAR",
    "BLIND_CORNER_LAGRANGIAN",
    "FAST",
    "LONGEST",
    "PAPER",
    "RECIPES",
    "TOWN",
    "Experiment",
    "ExperimentFileError",
    "load_experiment",
    "single_agent",
    "with_limits",
    "with_training",
]

RECIPES: dict[str, Experiment] = {
    experiment.recipe: experiment
    for experiment in (FAST, PAPER, TOWN, BLIND_CORNER, BLIND_CORNER_LAGRANGIAN, BLIND_CORNER_CVAR)
}
"""The recipes, by name."""
