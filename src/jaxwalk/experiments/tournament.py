"""Every driver among every population, for every training seed: who meets whom in `jaxwalk reproduce`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from jaxwalk.evaluation import (
    Match,
    compare,
    over_training_seeds,
    paired_over_seeds,
    with_jaywalk_multiplier,
)
from jaxwalk.interfaces import Policy
from jaxwalk.policies import DRIVERS
from jaxwalk.report import ALWAYS_GO, CO_TRAINED, LEARNED, SINGLE_AGENT
from jaxwalk.runs.contestants import contestant
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import HIDDEN

COMPARED = [name for name, make in DRIVERS.items() if make().view.name not in HIDDEN]
"""Rules that are compared: the oracle, which knows the future, is in no table of the paper's and takes minutes."""
MULTIPLIERS = (0.0, 0.1, 0.25, 0.6, 1.0)
"""Jaywalk multipliers of the ablation (paper, section IV-D)."""

Say = Callable[[str], None]
"""Called with a line when a cell has been played."""
Round = tuple[int | None, Mapping[str, Policy], Mapping[str, Policy]]
"""Training seed (None: nobody was trained), drivers and populations, who all meet."""


@dataclass(frozen=True)
class Trained:
    """The policies of one training seed."""

    seed: int
    drivers: Mapping[str, Policy]
    """The car trained alone, and the one trained with its pedestrians."""
    learned: Policy
    """Those pedestrians."""


@dataclass(frozen=True)
class Scenarios:
    """Which scenarios everybody meets."""

    episodes: int
    seed: int


def load_trained(street: Street, seed: int, folders: Mapping[str, Path]) -> Trained:
    """The policies in the run folders of a training seed, by the names of the trained drivers."""
    drivers = {name: contestant(street, "driver", str(folders[name])) for name in (SINGLE_AGENT, CO_TRAINED)}
    return Trained(seed, drivers, contestant(street, "pedestrian", str(folders[CO_TRAINED])))


def tournament(
    street: Street, trained: Sequence[Trained], scenarios: Scenarios, say: Say
) -> tuple[dict[str, Any], list[Match]]:
    """All drivers among both populations: the document of ``results.json``, and the matches.

    Rules among always-go play once; whatever was trained plays once for each training seed, its drivers among its own
    pedestrians.
    """
    rules = {name: contestant(street, "driver", name) for name in COMPARED}
    always_go = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO)}
    rounds: list[Round] = [(None, rules, always_go)]
    for one in trained:
        learned = {LEARNED: one.learned}
        rounds += [(one.seed, rules, learned), (one.seed, one.drivers, {**always_go, **learned})]
    start, matches = play_rounds(street, rounds, scenarios, say)
    places = {name: place for place, name in enumerate((*COMPARED, SINGLE_AGENT, CO_TRAINED))}
    matches.sort(key=lambda match: (places[match.cell.driver], match.cell.pedestrians != ALWAYS_GO))
    return {**document_of(start, matches), "paired": _pairs(matches)}, matches


def ablation(street: Street, trained: Sequence[Trained], scenarios: Scenarios, say: Say) -> dict[str, Any]:
    """The co-trained drivers with other jaywalk multipliers: the document of ``ablation.json``."""
    always_go = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO)}
    rounds: list[Round] = [
        (one.seed, {CO_TRAINED: one.drivers[CO_TRAINED]}, {**always_go, LEARNED: one.learned}) for one in trained
    ]
    start, matches = {}, []
    for multiplier in MULTIPLIERS:
        say(f"    multiplier {multiplier:g}")
        start, found = play_rounds(with_jaywalk_multiplier(street, multiplier), rounds, scenarios, say)
        matches += sorted(found, key=lambda match: match.cell.pedestrians != ALWAYS_GO)
    return document_of(start, matches)


def play_rounds(
    street: Street, rounds: Sequence[Round], scenarios: Scenarios, say: Say
) -> tuple[dict[str, Any], list[Match]]:
    """Everybody of each round against each other: the document of a round, for all but its cells, and all matches."""
    document, matches = {}, []
    for training_seed, drivers, people in rounds:
        told = partial(_tell, say, "" if training_seed is None else f", seed {training_seed}")
        results, rows = compare(
            street, drivers, people, Drawn(street, scenarios.seed, scenarios.episodes), progress=told
        )
        matches += [Match(cell, rows[cell.driver, cell.pedestrians], training_seed) for cell in results.cells]
        document = results.as_dict()
    return document, matches


def _tell(say: Say, of: str, driver: str, people: str, played: int, episodes: int) -> None:
    if played >= episodes:
        say(f"    {driver} among {people}{of}: {played:,} episodes")


def document_of(start: Mapping[str, Any], matches: Sequence[Match]) -> dict[str, Any]:
    """What `play_rounds` gave as one document: every match, and numbers over training seeds."""
    cells = [match.as_dict() for match in matches]
    return {**start, "cells": cells, "over_seeds": over_training_seeds(matches)}


def _pairs(matches: Sequence[Match]) -> list[dict[str, Any]]:
    """Learned against always-go for each driver, then the two trained drivers against each other."""

    def found(driver: str, pedestrians: str) -> list[Match]:
        return [match for match in matches if match.names == (driver, pedestrians)]

    drivers = dict.fromkeys(match.cell.driver for match in matches)
    people = [paired_over_seeds("collision", found(name, ALWAYS_GO), found(name, LEARNED)) for name in drivers]
    alone, together = found(SINGLE_AGENT, ALWAYS_GO), found(CO_TRAINED, ALWAYS_GO)
    return people + [paired_over_seeds(ending, alone, together) for ending in ("collision", "goal")]
