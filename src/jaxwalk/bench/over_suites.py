"""The cost of suites: the simulator alone in each one's world and on its streets, beside the paper's street."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from jaxwalk.bench.benchmark_settings import Settings
from jaxwalk.bench.in_turns import playing, take_turns
from jaxwalk.bench.simulation import Sets, paid_street
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.sim.suites import SUITES

SEEN: Sets = (("driver", "route-footprint"), ("pedestrian", "kerb"))
"""The observation sets that are computed: what the recipe `fast` trains with."""
BASE = ("paper", 12)
"""The suite and the number of people with whose speed the others are compared."""


def simulated(settings: Settings) -> list[dict[str, Any]]:
    """Return a row for each suite and number of people: the speed in each turn, and its ratio to the paper's street."""
    cases = list(dict.fromkeys([BASE, *product(settings.suites, settings.suite_pedestrians)]))
    streets = {suite: _street(suite) for suite, _ in cases}
    names = {case: f"suite {case[0]}, {case[1]} people" for case in cases}
    programs = {
        names[suite, people]: playing(streets[suite].with_people(people), settings.suite_environments, settings, SEEN)
        for suite, people in cases
    }
    turns = take_turns(programs, settings.turns)
    return [
        {
            "suite": suite,
            "pedestrians": people,
            "environments": settings.suite_environments,
            "env_steps_per_s": turns[names[suite, people]],
            "share_of_paper": np.divide(turns[names[suite, people]], turns[names[BASE]]).tolist(),
        }
        for suite, people in cases
    ]


def _street(suite: str) -> Street:
    where = SUITES[suite]
    return paid_street(WORLDS[where.world or BASE[0]], where.maps)
