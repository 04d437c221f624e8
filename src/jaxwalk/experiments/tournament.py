"""Play every driver among every population, for every training seed: the tournament of `jaxwalk reproduce`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from jaxwalk.evaluation import (
    Match,
    Results,
    evaluate_grid,
    every_two,
    over_training_seeds,
    paired_over_seeds,
    with_jaywalk_multiplier,
)
from jaxwalk.evaluation.document_parts import PairedSeeds, ScenarioSet, StreetOrigin
from jaxwalk.interfaces import Policy
from jaxwalk.provenance import provenance
from jaxwalk.report import ALWAYS_GO, CO_TRAINED, GAP_ACCEPTANCE, LEARNED, SINGLE_AGENT
from jaxwalk.runs.contestants import contestant
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.wording import counted

COMPARED = ["random", "constant-speed", "rule-based", "rule-based-braking", "route-follower", "clearance"]
"""Rules that are compared: the paper's four, the blind one, and the strong simple one."""
MULTIPLIERS = (0.0, 0.1, 0.25, 0.6, 1.0)
"""Jaywalk multipliers of the ablation (paper, section IV-D)."""

MET = (ALWAYS_GO, LEARNED, GAP_ACCEPTANCE)
"""The people that drivers meet, in the order of tables."""

Say = Callable[[str], None]
"""Called with a line of text when a cell has been played."""
Round = tuple[int | None, Mapping[str, Policy], Mapping[str, Policy]]
"""Training seed (None: nobody was trained), drivers and populations; each driver plays with each population."""


@dataclass(frozen=True)
class TrainedPolicies:
    """The policies of one training seed."""

    seed: int
    drivers: Mapping[str, Policy]
    """The car trained alone, and the car trained with its pedestrians."""
    learned: Policy
    """The pedestrians trained with the car."""


@dataclass(frozen=True)
class Scenarios:
    """The scenarios that everybody plays."""

    episodes: int
    seed: int


def load_trained(street: Street, seed: int, folders: Mapping[str, Path]) -> TrainedPolicies:
    """Load the policies of a training seed from its run folders, which are given by the trained drivers' names."""
    drivers = {name: contestant(street, "driver", str(folders[name])) for name in (SINGLE_AGENT, CO_TRAINED)}
    return TrainedPolicies(seed, drivers, contestant(street, "pedestrian", str(folders[CO_TRAINED])))


def tournament(
    street: Street, trained: Sequence[TrainedPolicies], scenarios: Scenarios, say: Say
) -> tuple[Results, list[Match]]:
    """Play all drivers among all populations; return the results of ``results.json``, and the matches.

    Rules among people who don't learn play once; trained policies play once for each training seed, the drivers among
    the pedestrians of the same seed.
    """
    rules = {name: contestant(street, "driver", name) for name in COMPARED}
    people = {name: contestant(street, "pedestrian", name) for name in (ALWAYS_GO, GAP_ACCEPTANCE)}
    rounds: list[Round] = [(None, rules, people)]
    for one in trained:
        learned = {LEARNED: one.learned}
        rounds += [(one.seed, rules, learned), (one.seed, one.drivers, {**people, **learned})]
    chosen, matches = play_rounds(street, rounds, scenarios, say)
    places = {name: place for place, name in enumerate((*COMPARED, SINGLE_AGENT, CO_TRAINED))}
    matches.sort(key=lambda match: (places[match.cell.driver], MET.index(match.cell.pedestrians)))
    found = results_of(street, chosen, matches, paired=_pairs(matches))
    return replace(found, every_two=every_two(matches)), matches


def ablation(street: Street, trained: Sequence[TrainedPolicies], scenarios: Scenarios, say: Say) -> Results:
    """Play the co-trained drivers with other jaywalk multipliers; return the results of ``ablation.json``."""
    always_go = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO)}
    rounds: list[Round] = [
        (one.seed, {CO_TRAINED: one.drivers[CO_TRAINED]}, {**always_go, LEARNED: one.learned}) for one in trained
    ]
    sets, matches = [], []
    for multiplier in MULTIPLIERS:
        say(f"    multiplier {multiplier:g}")
        chosen, found = play_rounds(with_jaywalk_multiplier(street, multiplier), rounds, scenarios, say)
        sets.append(chosen)
        matches += sorted(found, key=lambda match: match.cell.pedestrians != ALWAYS_GO)
    return results_of(street, sets[-1], matches)


def play_rounds(
    street: Street, rounds: Sequence[Round], scenarios: Scenarios, say: Say
) -> tuple[ScenarioSet, list[Match]]:
    """Play each round, every driver against every population; return the scenarios and all matches."""
    sets, matches = [], []
    for training_seed, drivers, people in rounds:
        told = partial(_tell, say, "" if training_seed is None else f", seed {training_seed}")
        results, rows = evaluate_grid(
            street, drivers, people, Drawn(street, scenarios.seed, scenarios.episodes), progress=told
        )
        sets.append(results.scenarios)
        for cell in results.cells:
            played = rows[cell.driver, cell.pedestrians]
            matches.append(Match(replace(cell, training_seed=training_seed), played))
    return sets[-1], matches


def _tell(say: Say, of: str, driver: str, people: str, played: int, episodes: int) -> None:
    if played >= episodes:
        say(f"    {driver} among {people}{of}: {counted(played, 'episode')}")


def results_of(
    street: Street, scenarios: ScenarioSet, matches: Sequence[Match], *, paired: Sequence[PairedSeeds] = ()
) -> Results:
    """Return every match's cell, the numbers over training seeds, and where and with which versions it was."""
    cells, over_seeds = tuple(match.cell for match in matches), over_training_seeds(matches)
    return Results(
        scenarios, cells, over_seeds=over_seeds, paired=tuple(paired), street=StreetOrigin.of(street), made=provenance()
    )


def _pairs(matches: Sequence[Match]) -> list[PairedSeeds]:
    """Compare learned with always-go for each driver, then the two trained drivers with each other."""

    def found(driver: str, pedestrians: str) -> list[Match]:
        return [match for match in matches if match.names == (driver, pedestrians)]

    drivers = dict.fromkeys(match.cell.driver for match in matches)
    people = [paired_over_seeds("collision", found(name, ALWAYS_GO), found(name, LEARNED)) for name in drivers]
    alone, together = found(SINGLE_AGENT, ALWAYS_GO), found(CO_TRAINED, ALWAYS_GO)
    return [*people, paired_over_seeds("collision", alone, together), paired_over_seeds("goal", alone, together)]
