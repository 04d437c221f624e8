"""Evaluate drivers among populations on the same scenarios: play, measure, compare, write documents and read them.

Start at `evaluate` in `batches.py`, and at `evaluate_grid` in `results.py`, which makes a document of it.
"""

from jaxwalk.evaluation.avoidable import CounterfactualSummary, summarise_counterfactuals
from jaxwalk.evaluation.batches import BATCH, episodes_at_once, evaluate, replay
from jaxwalk.evaluation.broken import ActionError, named
from jaxwalk.evaluation.comparison import EndingCounts, PairedEndings, compare_endings, paired
from jaxwalk.evaluation.counterfactual import Counterfactuals, ReplayError, counterfactuals
from jaxwalk.evaluation.document_parts import ComparedEnding, ScenarioSet
from jaxwalk.evaluation.encounter_file import check_parquet, write_encounters
from jaxwalk.evaluation.episode_file import write_rows
from jaxwalk.evaluation.ghosts import walk_ghosts
from jaxwalk.evaluation.hits import find_hits
from jaxwalk.evaluation.incidents import Incidents, describe, find_incidents
from jaxwalk.evaluation.playing import play
from jaxwalk.evaluation.results import Cell, Results, Stopped, evaluate_grid
from jaxwalk.evaluation.settings import SAMPLES, acts_by, jaywalk_multiplier, with_jaywalk_multiplier, with_mode
from jaxwalk.evaluation.training_seeds import Match, every_two, over_training_seeds, paired_delay, paired_over_seeds

__all__ = [
    "BATCH",
    "SAMPLES",
    "ActionError",
    "Cell",
    "ComparedEnding",
    "CounterfactualSummary",
    "Counterfactuals",
    "EndingCounts",
    "Incidents",
    "Match",
    "PairedEndings",
    "ReplayError",
    "Results",
    "ScenarioSet",
    "Stopped",
    "acts_by",
    "check_parquet",
    "compare_endings",
    "counterfactuals",
    "describe",
    "episodes_at_once",
    "evaluate",
    "evaluate_grid",
    "every_two",
    "find_hits",
    "find_incidents",
    "jaywalk_multiplier",
    "named",
    "over_training_seeds",
    "paired",
    "paired_delay",
    "paired_over_seeds",
    "play",
    "replay",
    "summarise_counterfactuals",
    "walk_ghosts",
    "with_jaywalk_multiplier",
    "with_mode",
    "write_encounters",
    "write_rows",
]
