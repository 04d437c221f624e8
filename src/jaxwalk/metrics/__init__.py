"""Trajectories measured: ``measure`` gives rows per episode, crossing and encounter; ``summarise`` gives numbers."""

from jaxwalk.metrics.measurement import Summary, measure, summarise
from jaxwalk.metrics.rows import Rows
from jaxwalk.metrics.statistics import Estimate, Rate, bootstrap_by_episode, kaplan_meier_median, mcnemar, wilson

__all__ = [
    "Estimate",
    "Rate",
    "Rows",
    "Summary",
    "bootstrap_by_episode",
    "kaplan_meier_median",
    "mcnemar",
    "measure",
    "summarise",
    "wilson",
]
