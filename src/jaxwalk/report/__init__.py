"""Make tables, figures and one HTML file from results, next to the paper's numbers."""

from jaxwalk.report.material import (
    ALWAYS_GO,
    CLEARANCE,
    CO_TRAINED,
    GAP_ACCEPTANCE,
    LEARNED,
    ROUTE_FOLLOWER,
    SINGLE_AGENT,
    DrawnEpisode,
    LearningCurve,
    Material,
    ReportError,
    Trainings,
)
from jaxwalk.report.watched import Gallery
from jaxwalk.report.write import write_report

__all__ = [
    "ALWAYS_GO",
    "CLEARANCE",
    "CO_TRAINED",
    "GAP_ACCEPTANCE",
    "LEARNED",
    "ROUTE_FOLLOWER",
    "SINGLE_AGENT",
    "DrawnEpisode",
    "Gallery",
    "LearningCurve",
    "Material",
    "ReportError",
    "Trainings",
    "write_report",
]
