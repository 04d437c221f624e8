"""Metrics of trajectories: `measure` gives rows per episode, crossing and encounter; `summarise` gives numbers.

Metrics are objects: ``rows[OUTCOMES]`` and ``summary[OUTCOMES]`` are what `OUTCOMES` measured, with its types.
"""

from jaxwalk.metrics.approaches import APPROACHES
from jaxwalk.metrics.attribution import ATTRIBUTION
from jaxwalk.metrics.comfort import COMFORT
from jaxwalk.metrics.counts import clustered_rate, clustered_share, proportion, rate, rate_ratio
from jaxwalk.metrics.crossings import CROSSINGS
from jaxwalk.metrics.decisions import JAYWALK_RATE
from jaxwalk.metrics.delay import DELAY
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.gaps import GAPS
from jaxwalk.metrics.impact_tail import IMPACT_TAIL
from jaxwalk.metrics.interventions_by_shield import SHIELD_INTERVENTIONS
from jaxwalk.metrics.measurement import Summary, measure, summarise
from jaxwalk.metrics.meetings import MEETINGS
from jaxwalk.metrics.metric import Finding, Metric, MetricTable, NoRows, Recording, Rows, Sums
from jaxwalk.metrics.near_misses import NEAR_MISSES
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.over_seeds import FEWEST_SEEDS, OverSeeds, crossed_mean, interquartile_mean, over_seeds
from jaxwalk.metrics.paired_tests import SURE, holm, mcnemar, paired_difference
from jaxwalk.metrics.passing import PASSING
from jaxwalk.metrics.power import scenarios_needed
from jaxwalk.metrics.registry import METRICS
from jaxwalk.metrics.severity import SURROGATE_DISTRIBUTIONS
from jaxwalk.metrics.speed_differential import PLACEBO, SPEED_DIFFERENTIAL
from jaxwalk.metrics.statistics import Estimate, Rate, bootstrap_by_episode, kaplan_meier_median
from jaxwalk.metrics.surrogate import SURROGATES
from jaxwalk.metrics.waiting import WAITING

__all__ = [
    "APPROACHES",
    "ATTRIBUTION",
    "COMFORT",
    "CROSSINGS",
    "DELAY",
    "ENCOUNTERS",
    "FEWEST_SEEDS",
    "GAPS",
    "IMPACT_TAIL",
    "JAYWALK_RATE",
    "MEETINGS",
    "METRICS",
    "NEAR_MISSES",
    "OUTCOMES",
    "PASSING",
    "PLACEBO",
    "SHIELD_INTERVENTIONS",
    "SPEED_DIFFERENTIAL",
    "SURE",
    "SURROGATES",
    "SURROGATE_DISTRIBUTIONS",
    "WAITING",
    "Estimate",
    "Finding",
    "Metric",
    "MetricTable",
    "NoRows",
    "OverSeeds",
    "Rate",
    "Recording",
    "Rows",
    "Summary",
    "Sums",
    "bootstrap_by_episode",
    "clustered_rate",
    "clustered_share",
    "crossed_mean",
    "holm",
    "interquartile_mean",
    "kaplan_meier_median",
    "mcnemar",
    "measure",
    "over_seeds",
    "paired_difference",
    "proportion",
    "rate",
    "rate_ratio",
    "scenarios_needed",
    "summarise",
]
