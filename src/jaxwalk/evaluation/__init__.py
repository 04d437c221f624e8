"""Evaluate drivers among populations on the same scenarios: play, measure, compare, write documents and read them.

Start at `evaluate` in `batches.py`, and at `evaluate_grid` in `results.py`, which makes a document of it. A name is
imported when it is first used: trainings need little of this.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from jaxwalk.lazy import imported_when_used

if TYPE_CHECKING:
    from jaxwalk.evaluation.avoidable import CounterfactualSummary as CounterfactualSummary
    from jaxwalk.evaluation.avoidable import summarise_counterfactuals as summarise_counterfactuals
    from jaxwalk.evaluation.batches import BATCH as BATCH
    from jaxwalk.evaluation.batches import episodes_at_once as episodes_at_once
    from jaxwalk.evaluation.batches import evaluate as evaluate
    from jaxwalk.evaluation.batches import replay as replay
    from jaxwalk.evaluation.broken import ActionError as ActionError
    from jaxwalk.evaluation.broken import named as named
    from jaxwalk.evaluation.comparison import EndingCounts as EndingCounts
    from jaxwalk.evaluation.comparison import PairedEndings as PairedEndings
    from jaxwalk.evaluation.comparison import compare_endings as compare_endings
    from jaxwalk.evaluation.comparison import paired as paired
    from jaxwalk.evaluation.counterfactual import Counterfactuals as Counterfactuals
    from jaxwalk.evaluation.counterfactual import ReplayError as ReplayError
    from jaxwalk.evaluation.counterfactual import counterfactuals as counterfactuals
    from jaxwalk.evaluation.document_parts import ComparedEnding as ComparedEnding
    from jaxwalk.evaluation.document_parts import ScenarioSet as ScenarioSet
    from jaxwalk.evaluation.encounter_file import check_parquet as check_parquet
    from jaxwalk.evaluation.encounter_file import write_encounters as write_encounters
    from jaxwalk.evaluation.episode_file import write_rows as write_rows
    from jaxwalk.evaluation.ghosts import walk_ghosts as walk_ghosts
    from jaxwalk.evaluation.hits import find_hits as find_hits
    from jaxwalk.evaluation.incidents import Incidents as Incidents
    from jaxwalk.evaluation.incidents import describe as describe
    from jaxwalk.evaluation.incidents import find_incidents as find_incidents
    from jaxwalk.evaluation.playing import play as play
    from jaxwalk.evaluation.results import Cell as Cell
    from jaxwalk.evaluation.results import Results as Results
    from jaxwalk.evaluation.results import Stopped as Stopped
    from jaxwalk.evaluation.results import evaluate_grid as evaluate_grid
    from jaxwalk.evaluation.settings import SAMPLES as SAMPLES
    from jaxwalk.evaluation.settings import acts_by as acts_by
    from jaxwalk.evaluation.settings import jaywalk_multiplier as jaywalk_multiplier
    from jaxwalk.evaluation.settings import with_jaywalk_multiplier as with_jaywalk_multiplier
    from jaxwalk.evaluation.settings import with_mode as with_mode
    from jaxwalk.evaluation.training_seeds import Match as Match
    from jaxwalk.evaluation.training_seeds import every_two as every_two
    from jaxwalk.evaluation.training_seeds import over_training_seeds as over_training_seeds
    from jaxwalk.evaluation.training_seeds import paired_delay as paired_delay
    from jaxwalk.evaluation.training_seeds import paired_over_seeds as paired_over_seeds

_HOMES = {
    "BATCH": "batches",
    "SAMPLES": "settings",
    "ActionError": "broken",
    "Cell": "results",
    "ComparedEnding": "document_parts",
    "CounterfactualSummary": "avoidable",
    "Counterfactuals": "counterfactual",
    "EndingCounts": "comparison",
    "Incidents": "incidents",
    "Match": "training_seeds",
    "PairedEndings": "comparison",
    "ReplayError": "counterfactual",
    "Results": "results",
    "ScenarioSet": "document_parts",
    "Stopped": "results",
    "acts_by": "settings",
    "check_parquet": "encounter_file",
    "compare_endings": "comparison",
    "counterfactuals": "counterfactual",
    "describe": "incidents",
    "episodes_at_once": "batches",
    "evaluate": "batches",
    "evaluate_grid": "results",
    "every_two": "training_seeds",
    "find_hits": "hits",
    "find_incidents": "incidents",
    "jaywalk_multiplier": "settings",
    "named": "broken",
    "over_training_seeds": "training_seeds",
    "paired": "comparison",
    "paired_delay": "training_seeds",
    "paired_over_seeds": "training_seeds",
    "play": "playing",
    "replay": "batches",
    "summarise_counterfactuals": "avoidable",
    "walk_ghosts": "ghosts",
    "with_jaywalk_multiplier": "settings",
    "with_mode": "settings",
    "write_encounters": "encounter_file",
    "write_rows": "episode_file",
}
"""Each public name, and the module of this package that defines it."""

__all__ = [*_HOMES]  # pyright: ignore[reportUnsupportedDunderAll]

__getattr__, __dir__ = imported_when_used(__name__, _HOMES)
