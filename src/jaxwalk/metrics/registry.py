"""All metrics of the suite. A line here adds a metric."""

from __future__ import annotations

from typing import Any

from jaxwalk.metrics.approaches import APPROACHES
from jaxwalk.metrics.attribution import ATTRIBUTION
from jaxwalk.metrics.comfort import COMFORT
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.metrics.decisions import JAYWALK_RATE
from jaxwalk.metrics.delay import DELAY
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.gaps import GAPS
from jaxwalk.metrics.impact_tail import IMPACT_TAIL
from jaxwalk.metrics.interventions_by_shield import SHIELD_INTERVENTIONS
from jaxwalk.metrics.metric import Metric
from jaxwalk.metrics.near_misses import NEAR_MISSES
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.passing import PASSING
from jaxwalk.metrics.severity import SURROGATE_DISTRIBUTIONS
from jaxwalk.metrics.speed_differential import SPEED_DIFFERENTIAL
from jaxwalk.metrics.surrogate import SURROGATES
from jaxwalk.metrics.waiting import WAITING

METRICS: tuple[Metric[Any, Any], ...] = (
    OUTCOMES,
    ATTRIBUTION,
    ENCOUNTERS,
    SURROGATES,
    SURROGATE_DISTRIBUTIONS,
    SPEED_DIFFERENTIAL,
    JAYWALK_RATE,
    WAITING,
    DELAY,
    APPROACHES,
    GAPS,
    PASSING,
    COMFORT,
    MEASURED_CONTACTS,
    NEAR_MISSES,
    SHIELD_INTERVENTIONS,
    IMPACT_TAIL,
)
"""Add new metrics at the end: the last bit of a sum depends on the position of its column, and published numbers must
not change."""
