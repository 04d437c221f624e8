"""Metrics of trajectories: `measure` gives rows per episode, crossing and encounter; `summarise` gives numbers.

Metrics are objects: ``rows[OUTCOMES]`` and ``summary[OUTCOMES]`` are what `OUTCOMES` measured, with its types.
"""

from jaxwalk.metrics.attribution import ATTRIBUTION
from jaxwalk.metrics.crossings import CROSSINGS
from jaxwalk.metrics.decisions import JAYWALK_RATE
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.measurement import Summary, measure, summarise
from jaxwalk.metrics.meetings import MEETINGS
from jaxwalk.metrics.metric import Finding, Metric, MetricTable, NoRows, Recording, Rows, Sums
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.power import scenarios_needed
from jaxwalk.metrics.registry import METRICS
from jaxwalk.metrics.severity import SURROGATE_DISTRIBUTIONS
from jaxwalk.metrics.speed_differential import PLACEBO, SPEED_DIFFERENTIAL
from jaxwalk.metrics.statistics import (
    Estimate,
    OverSeeds,
    Rate,
    bootstrap_by_episode,
    holm,
    interquartile_mean,
    kaplan_meier_median,
    mcnemar,
    over_seeds,
    wilson,
)
from jaxwalk.metrics.surrogate import SURROGATES
from jaxwalk.metrics.waiting import WAITING

__all__ = [
    "ATTRIBUTION",
    "CROSSINGS",
    "ENCOUNTERS",
    "JAYWALK_RATE",
    "MEETINGS",
    "METRICS",
    "OUTCOMES",
    "PLACEBO",
    "SPEED_DIFFERENTIAL",
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
    "holm",
    "interquartile_mean",
    "kaplan_meier_median",
    "mcnemar",
    "measure",
    "over_seeds",
    "scenarios_needed",
    "summarise",
    "wilson",
]
