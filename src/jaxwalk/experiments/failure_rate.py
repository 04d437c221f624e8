"""`jaxwalk search --method splitting`: how rare are failures of a driver? The unbiased rate, in rate.json."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from jaxwalk.evaluation import named
from jaxwalk.evaluation.document_parts import StreetOrigin
from jaxwalk.interfaces import Policy
from jaxwalk.provenance import provenance
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.search.driving import Driving
from jaxwalk.search.splitting import SplittingPlan, rare_rate
from jaxwalk.sim.environment import Street
from jaxwalk.writing import write_whole

RATE = "rate.json"
RATE_SCHEMA = 1
"""Version of the document."""


@dataclass(frozen=True)
class FailureRate:
    """Whose rate to estimate."""

    street: Street
    drivers: Mapping[str, Policy]
    """The driver, by its name."""
    people: Mapping[str, Policy]
    """The population, by its name."""
    plan: SplittingPlan
    seed: int
    out: Path


def estimate_rate(work: FailureRate, tell: Callable[[str, int, int], None]) -> str:
    """Estimate the rate, write the document, and return the result in words.

    Raises:
        SplittingError: no failure was reached.
        DriverError, ActionError: a policy failed.
    """
    (driver, car), (people, crowd) = *work.drivers.items(), *work.people.items()
    game = Driving(work.street, {"driver": car, "pedestrian": crowd}, work.seed)
    total = work.plan.repeats + 1
    tell("pilot run", 0, total)
    with named({"driver": driver, "pedestrian": people}):
        found = rare_rate(game, work.plan, work.seed, lambda run, _: tell("estimating", run + 1, total))
    document = {
        "schema": RATE_SCHEMA,
        "driver": asdict(policy_origin("driver", driver)),
        "pedestrians": asdict(policy_origin("pedestrian", people)),
        "plan": asdict(work.plan),
        "seed": work.seed,
        "rate": asdict(found),
        "street": StreetOrigin.of(work.street).as_dict(),
        "made": asdict(provenance()),
    }
    write_whole(work.out / RATE, json.dumps(document, indent=2, allow_nan=False) + "\n")
    many = f"{len(found.estimates)} estimates, {len(found.levels)} levels, {found.simulations:,} scenarios"
    return (
        f"{driver}: the moving car touches somebody in {found.value:.3g} of the scenarios "
        f"[{found.low:.3g}, {found.high:.3g}] ({many})\n{work.out / RATE} has all numbers"
    )
