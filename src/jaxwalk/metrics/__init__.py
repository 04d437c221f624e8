"""Trajectories measured: ``measure`` gives rows per episode, crossing and encounter; ``summarise`` gives numbers."""

from jaxwalk.metrics.measurement import Summary, measure, summarise
from jaxwalk.metrics.power import scenarios_needed
from jaxwalk.metrics.rows import Rows
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

__all__ = [
    "Estimate",
    "OverSeeds",
    "Rate",
    "Rows",
    "Summary",
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
