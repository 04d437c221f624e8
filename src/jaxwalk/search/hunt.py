"""A search in progress: generation after generation, and what it has found so far; it can be kept and goes on later."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import safetensors.numpy
from pydantic import TypeAdapter, ValidationError

from jaxwalk.scenarios.archive_file import ArchiveError, read_tensors
from jaxwalk.search.cube import Candidates
from jaxwalk.search.driving import Driving
from jaxwalk.search.elites import Elites
from jaxwalk.search.evolution import Evolution
from jaxwalk.search.grid import CELLS, GRID
from jaxwalk.search.map_elites import MapElites
from jaxwalk.search.methods import CrossEntropy, Generation, Method, RandomSearch, State
from jaxwalk.writing import write_whole

STATE: Final = "state.safetensors"
"""Name of the file in which a search in progress is kept."""
HEADER: Final = "jaxwalk-search"
"""The header's entry of that file."""
LEARNED: Final = "learned."
"""Arrays of the method's state are named so."""
ADVICE: Final = "search anew in another folder"

MethodName = Literal["map-elites", "cross-entropy", "evolution", "random"]
"""Names of the methods."""


@dataclass(frozen=True)
class Progressed:
    """What a search had found after a generation."""

    simulations: int
    """Scenarios played so far."""
    failures: int
    """How many of them failed."""
    cells: int
    """Different cells with a failure."""


@dataclass
class Hunt:
    """A search in progress."""

    elites: Elites
    learned: State
    log: list[Progressed] = field(default_factory=list)

    @property
    def simulations(self) -> int:
        """Return how many scenarios have been played."""
        return self.log[-1].simulations if self.log else 0


def method_of(name: MethodName, game: Driving) -> Method:
    """Return the method of a name, for generations of the game's batch.

    Raise EvosaxError if it needs evosax, which is missing.
    """
    if name == "evolution":
        return Evolution(game.batch)
    methods: dict[str, Method] = {
        "map-elites": MapElites(game.street), "cross-entropy": CrossEntropy(), "random": RandomSearch(),
    }  # fmt: skip
    return methods[name]


def begun(game: Driving, method: Method) -> Hunt:
    """Return a search that has played nothing."""
    return Hunt(Elites.none(game.dimensions), method.begin(game.dimensions))


def play_generation(game: Driving, method: Method, hunt: Hunt, seed: int) -> None:
    """Play one more generation of a search, a batch; chance is decided by the seed and the generation's number.

    Errors are those of `Driving.play`.
    """
    number = len(hunt.log)
    turn = Generation(np.random.default_rng([seed, number]), number, game.batch)
    candidates = method.ask(hunt.learned, hunt.elites, turn)
    played = game.play(candidates)
    hunt.elites = hunt.elites.joined_by(candidates, played)
    hunt.learned = method.tell(hunt.learned, candidates, played.moments.score)
    failures = (hunt.log[-1].failures if hunt.log else 0) + int(played.moments.failed.sum())
    cells = int(hunt.elites.best_failures.sum())
    hunt.log.append(Progressed(hunt.simulations + len(candidates), failures, cells))


def keep_hunt(path: Path, hunt: Hunt, plan: Mapping[str, Any]) -> None:
    """Write a search in progress, with its plan as JSON. The file appears whole or not at all."""
    elites = hunt.elites
    arrays = {
        "cells": elites.cells, "quality": elites.quality, "points": elites.candidates.points,
        "keys": elites.candidates.keys, "visits": elites.visits,
        "log": np.array([(row.simulations, row.failures, row.cells) for row in hunt.log], np.int64).reshape(-1, 3),
        **{f"{LEARNED}{name}": np.array(array, order="C") for name, array in hunt.learned.items()},
    }  # fmt: skip
    text = json.dumps({"grid": GRID, "plan": plan}, sort_keys=True, allow_nan=False)
    write_whole(path, safetensors.numpy.save(arrays, {HEADER: text}))


def kept_hunt(path: Path, fresh: Hunt, plan: Mapping[str, Any]) -> Hunt:
    """Return the search that a file keeps; ``fresh`` is one that has played nothing.

    Raises ArchiveError if the file is damaged, or keeps a search of another plan.
    """
    text, arrays = read_tensors(path, HEADER, "search in progress")
    _check_plan(path, text, plan)
    learned = {name.removeprefix(LEARNED): array for name, array in arrays.items() if name.startswith(LEARNED)}
    own = [_shape(fresh.learned[name]) == _shape(learned.get(name)) for name in fresh.learned]
    shapes = ("cells", "quality", "points", "keys", "visits", "log")
    if not all(own) or len(learned) != len(own) or not all(name in arrays for name in shapes):
        raise ArchiveError(f"{path}: lacks what its method has learned; {ADVICE}")
    cells, quality, points, keys, visits, log = (arrays[name] for name in shapes)
    count, numbers = len(cells), fresh.elites.candidates.points.shape[1]
    kinds = [array.dtype.kind for array in (cells, quality, keys, visits, log)]
    fit = points.shape == (count, numbers) and points.dtype == np.float32 and kinds == ["i", "f", "i", "i", "i"]
    if (
        not fit
        or not cells.shape == quality.shape == keys.shape == (count,)
        or visits.shape != (CELLS,)
        or log.ndim != 2
        or log.shape[1] != 3
    ):
        raise ArchiveError(f"{path}: its arrays have other sizes than those of this street; {ADVICE}")
    if not (((cells >= 0) & (cells < CELLS)).all() and (np.diff(cells) >= 0).all() and _inside(points)):
        raise ArchiveError(f"{path}: has impossible cells or points; {ADVICE}")
    if (visits < 0).any():
        raise ArchiveError(f"{path}: has cells reached fewer than 0 times; {ADVICE}")
    if (visits[cells] == 0).any():
        raise ArchiveError(f"{path}: has cells of its scenarios that were never reached; {ADVICE}")
    rows = [Progressed(*row) for row in log.tolist()]
    return Hunt(Elites(cells, quality, Candidates(points, keys), visits), learned, rows)


def _shape(array: np.ndarray | None) -> tuple[Any, ...]:
    return () if array is None else (array.shape, array.dtype.kind)


def _inside(points: np.ndarray) -> bool:
    return bool(((points >= 0) & (points < 1)).all())


def _check_plan(path: Path, text: str, plan: Mapping[str, Any]) -> None:
    """Raise ArchiveError unless the file keeps a search of this plan and of this version's grid."""
    try:
        header = TypeAdapter(dict[str, Any]).validate_json(text)
        there = TypeAdapter(dict[str, Any]).validate_python(header.get("plan"))
    except (ValidationError, RecursionError) as error:
        raise ArchiveError(f"{path}: its header is damaged; {ADVICE}") from error
    if header.get("grid") != GRID:
        raise ArchiveError(f"{path}: has another version of the grid; {ADVICE}")
    asked = json.loads(json.dumps(plan))
    for name in (name for name in {**asked, **there} if there.get(name) != asked.get(name)):
        raise ArchiveError(f"{path}: was begun with another value of {name[:40]}; ask for the same again, or {ADVICE}")
