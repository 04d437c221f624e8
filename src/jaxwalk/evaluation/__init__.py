"""Drivers meet populations on the same scenarios: play, evaluate, compare, write down."""

from jaxwalk.evaluation.comparison import Comparison, Paired, compared, paired
from jaxwalk.evaluation.encounter_file import check_parquet, write_encounters
from jaxwalk.evaluation.game import play
from jaxwalk.evaluation.results import Cell, Results, compare, write_rows
from jaxwalk.evaluation.scenarios import BATCH, draw_scenarios, evaluate, replay, scenario_hash
from jaxwalk.evaluation.settings import SAMPLES, jaywalk_multiplier, mode, with_jaywalk_multiplier, with_mode
from jaxwalk.evaluation.training_seeds import Match, over_training_seeds, paired_over_seeds

__all__ = [
    "BATCH",
    "SAMPLES",
    "Cell",
    "Comparison",
    "Match",
    "Paired",
    "Results",
    "check_parquet",
    "compare",
    "compared",
    "draw_scenarios",
    "evaluate",
    "jaywalk_multiplier",
    "mode",
    "over_training_seeds",
    "paired",
    "paired_over_seeds",
    "play",
    "replay",
    "scenario_hash",
    "with_jaywalk_multiplier",
    "with_mode",
    "write_encounters",
    "write_rows",
]
