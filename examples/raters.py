"""Raters: twelve simulated people compare three cars, and the analysis says what may be said about them."""

import numpy as np

from jaxwalk.evaluation.document_parts import ScenarioSet
from jaxwalk.provenance import Provenance
from jaxwalk.raters import DriverMeasure, RatedPair, RaterFile, RatingPlan, analyse, answers_page
from jaxwalk.raters.answer_files import RaterAnswer

# `jaxwalk rate` makes such a plan with its page; here every two of three drivers are compared in four scenarios.
duos = [(0, 1), (1, 2), (2, 0)] * 4
pairs = [RatedPair(scenario, a, b, 0.0) for scenario, (a, b) in enumerate(duos)]
check = RatedPair(99, 0, 2, 0.0, "a")
plan = RatingPlan(
    drivers=("calm", "brisk", "rash"), players=("calm", "brisk", "rash"), pedestrians="always-go",
    scenarios=ScenarioSet(100, "0123456789abcdef", 0), seed=0, each=len(pairs), pairs=(*pairs, check),
    measures=(DriverMeasure("hits", False, (0.001, 0.01, 0.2)),), made=Provenance(None, "", {}),
)  # fmt: skip

rng = np.random.default_rng(0)
strengths = np.array([1.5, 0.5, -2.0])  # what these raters think; people's files come from the page


def answered(place: int) -> RaterAnswer:
    """Return an answer by Davidson's model."""
    pair = plan.pairs[place]
    a, b = strengths[pair.a], strengths[pair.b]
    weights = np.exp([a, b, (a + b) / 2])
    drawn = rng.choice(3, p=weights / weights.sum()) if place < len(pairs) else 0
    return RaterAnswer(place, "a", ("left", "right", "equal")[drawn], 9.0, False)


files = [
    RaterFile(1, plan.id, f"{rater:016x}", True, True, tuple(map(answered, range(len(plan.pairs)))))
    for rater in range(12)
]
print(answers_page(plan, analyse(plan, files)))
