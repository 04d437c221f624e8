"""What a report is made of: a few hand-made episodes, met by every driver."""

from __future__ import annotations

import numpy as np

from jaxwalk.evaluation import (
    Cell,
    Counterfactuals,
    Match,
    Results,
    ScenarioSet,
    over_training_seeds,
    paired_over_seeds,
    summarise_counterfactuals,
)
from jaxwalk.metrics import measure, summarise
from jaxwalk.provenance import Provenance
from jaxwalk.report import DrawnEpisode, LearningCurve, Material, Trainings
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, trajectory

DRIVERS = (
    "random",
    "constant-speed",
    "rule-based",
    "rule-based-braking",
    "route-follower",
    "single-agent",
    "co-trained",
)


PEOPLE = [
    Walk(30.0, -4.0, vy=1.0, crossings=[(2, 40, CROSSWALK)], kerb=[0, 1], waits=[1], miss=1.0),
    Walk(40.0, 4.0, vy=-1.0, crossings=[(5, 45, JAYWALK)]),
]
REACHED = Scene(50, PEOPLE, goal=True)
HIT = Scene(50, [Walk(25.0, 0.0, crossings=[(20, 50, JAYWALK)]), PEOPLE[0]], touched=[0])
SCENES = {5: (REACHED, HIT, REACHED), 6: (REACHED, HIT, HIT), 7: (HIT, HIT, HIT)}
"""What every driver met, by training seed."""

YES, NO = np.array([True]), np.array([False])
REPLAYED = summarise_counterfactuals(
    Counterfactuals(
        collisions=1, scenario=np.array([1]), contact=np.array([JAYWALK]), moving=YES, seen_for=np.array([4.0]),
        notice=np.array([3.0]), crosswalk_applies=YES, wait_applies=YES, crosswalk=YES, wait=YES, brake=NO, planner=NO,
        planner_from_start=YES, human_when_seen=YES, human_from_start=NO, brake_when_seen=NO, planner_when_seen=NO,
    )
)  # fmt: skip
"""A careful human would have avoided it, though not from the start."""


def material(seeds):
    """A report's material on so many training seeds."""
    rows = {seed: measure(trajectory(*scenes)) for seed, scenes in SCENES.items() if seed < 5 + seeds}
    updates = range(1, 9)
    curve = LearningCurve(
        steps=tuple(64 * n for n in updates), seconds=8.0, episodes=tuple(map(float, updates)),
        goal_rate=(0.5,) * 8, collision_rate=(0.25,) * 8, timeout_rate=(0.25,) * 8,
    )  # fmt: skip
    return Material(
        results=_results(rows, DRIVERS, (0.25,)),
        ablation=_results(rows, ("co-trained",), (0.0, 0.1, 0.25, 0.6, 1.0)),
        curves={name: dict.fromkeys(rows, curve) for name in ("co-trained", "single-agent")},
        provenance=Provenance(commit="abc123", hardware="an abacus", versions={"jax": "0.10.2"}),
        trainings=Trainings("fast", tuple(rows)),
        minutes={"evaluate": 1.5},
        episode=DrawnEpisode(scenario=2, seed=5, training_seed=5),
        collision=DrawnEpisode(1, 5, 5, 50, "route-follower", "always-go"),
        collision_svg='<?xml version="1.0"?><svg width="9pt" height="9pt"></svg>',
        episode_svg='<?xml version="1.0"?><svg width="9pt" height="9pt"><path id="p" clip-path="url(#p)"/></svg>',
    )


def _results(rows, drivers, multipliers):
    summaries = {seed: summarise(found, resamples=20) for seed, found in rows.items()}
    matches = [
        Match(
            Cell(
                driver, people, "mode", "sample", multiplier, summaries[seed], "route", "kerb",
                training_seed=seed, counterfactuals=REPLAYED,
            ),
            rows[seed],
        )
        for driver in drivers
        for multiplier in multipliers
        for people in ("always-go", "learned")
        for seed in rows
        if seed == 5 or not _untrained(driver, people)
    ]  # fmt: skip
    by_name = {driver: [m for m in matches if m.names == (driver, "always-go")] for driver in drivers}
    pairs = (paired_over_seeds("collision", by_name[drivers[0]], by_name[drivers[-1]]),)
    cells = tuple(match.cell for match in matches)
    scenarios = ScenarioSet(count=3, hash="0123456789abcdef", seed=5)
    return Results(scenarios, cells, over_seeds=over_training_seeds(matches), paired=pairs)


def _untrained(driver, people):
    return people == "always-go" and driver not in ("single-agent", "co-trained")
