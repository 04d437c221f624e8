"""Scripted tests as a source of scenarios: protocols of crash tests, and anybody's own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import shapely
from jaxtyping import Array, Int, Key

from jaxwalk.maps import MapText
from jaxwalk.rollout import EVALUATION, environment_keys, seed_key
from jaxwalk.scenarios.crash_suite import STANDARD, CrashFileError, CrashSuite, Variant
from jaxwalk.scenarios.rails import Rails
from jaxwalk.scenarios.script_file import read_script
from jaxwalk.scenarios.source import source_hash
from jaxwalk.scenarios.staging import NOBODY, Case, Stage, Staged, StagedPerson, cases_of, layers_of
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import FAR_AWAY, TRAITS, Scenario
from jaxwalk.sim.script import Script
from jaxwalk.sim.sim_config import WORLDS, SimConfig
from jaxwalk.sim.suites import CRASH_WORLD

NO_BOX = (FAR_AWAY, FAR_AWAY, 1.0, 0.0, 0.0, 0.0)
"""A parked vehicle that isn't there."""


@dataclass(frozen=True)
class Scripted:
    """The runs of a suite's tests. Scenario i is run i; nothing in it is drawn."""

    street: Street
    """The suite's track, in the world of crash tests."""
    suite: CrashSuite
    cases: tuple[Case, ...]
    """The run of each scenario."""
    scenarios: Scenario
    """All scenarios, arrays ``(..., case)``."""

    @classmethod
    def load(cls, name_or_path: str | Path, *, layers: tuple[str, ...] = (STANDARD,)) -> Scripted:
        """Return the runs of a suite that ships with jaxwalk, or of a file, that belong to some of its layers.

        Raises CrashFileError if it can't be used, and MapError if its track can't.
        """
        suite, track = read_script(name_or_path)
        return cls.of(suite, str(name_or_path), layers=layers, track=track)

    @classmethod
    def of(
        cls,
        suite: CrashSuite,
        source: str,
        *,
        layers: tuple[str, ...] = (STANDARD,),
        track: MapText | None = None,
        rules: SimConfig = WORLDS[CRASH_WORLD],
    ) -> Scripted:
        """Return the runs of a suite; ``source`` names it in errors, which are those of `load`.

        ``track`` is the street, in place of that which the suite names, and ``rules`` are those of the world.
        """
        cases = cases_of(suite.tests, layers)
        if not cases:
            known = ", ".join(layers_of(suite))
            raise CrashFileError(f"{source}: no test is of layer {', '.join(layers)}; there are {known}")
        people = max(1, *(len(case.test.people) for case in cases))
        horizon = round(suite.lasts / rules.dt)
        street = Street.create((track or suite.track,), replace(rules, pedestrians=people, horizon=horizon))
        stage = Stage(street, source)
        staged = [stage.staged(case, suite.variants.get(case.variant or "", Variant())) for case in cases]
        return cls(street, suite, cases, _scenarios(street, staged))

    @property
    def script(self) -> Script:
        """Return the script of all scenarios."""
        script = self.scenarios.script
        assert script is not None
        return script

    def route(self, number: int) -> shapely.LineString:
        """Return the car's route in a scenario [m]."""
        rails = Rails.of(self.street.world.maps, 0, int(self.scenarios.route[number]))
        return shapely.LineString(np.column_stack([rails.x, rails.y]))

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(self.cases)

    def take(self, numbers: Int[np.ndarray, "episode"]) -> tuple[Scenario, Key[Array, "episode"]]:
        """Return the scenarios of these numbers, and a key for each. Raise ValueError for a number out of range."""
        for wrong in numbers[(numbers < 0) | (numbers >= len(self))][:1]:
            raise ValueError(f"scenario must lie in [0, {len(self)}), not {wrong}")
        scenarios = jax.tree.map(lambda column: jnp.asarray(np.asarray(column)[..., numbers]), self.scenarios)
        return scenarios, environment_keys(seed_key(0, EVALUATION), 0, len(self))[jnp.asarray(numbers)]

    def hash(self) -> str:
        """Return the hash of the scenarios."""
        return source_hash(self)

    def describe(self) -> dict[str, Any]:
        """Return the suite, the count and the hash."""
        return {"kind": "scripted", "suite": self.suite.name, "count": len(self), "hash": self.hash()}


def _scenarios(street: Street, staged: list[Staged]) -> Scenario:
    """Return the scenarios of staged cases, arrays ``(..., case)``."""
    world, people, count = street.world, street.world.rules.pedestrians, len(staged)
    none = np.zeros((people, count), np.int32)
    middle = np.full((1, people, count), 0.5, np.float32)
    columns: dict[str, Any] = {
        "map": np.zeros(count, np.int32),
        "route": np.array([one.route for one in staged], np.int32),
        "start": none,
        "traits": np.repeat(middle, TRAITS, axis=0),
        "goals": np.repeat(none[None], world.goals, axis=0),
        "jaywalk_draw": np.repeat(middle, world.crossings, axis=0),
        "zone_draw": np.repeat(middle, world.crossings, axis=0),
    }
    on_device, script = jax.device_put((columns, _script_columns(staged, people)))
    return Scenario(**on_device, script=Script(**script))


def _script_columns(staged: list[Staged], people: int) -> dict[str, Any]:
    """Return the fields of a `Script`, NumPy arrays ``(..., case)``."""
    crowds = [(*one.people, *[NOBODY] * (people - len(one.people))) for one in staged]
    points = max(len(person.way.points) for crowd in crowds for person in crowd)
    boxes = max(1, *(len(one.boxes) for one in staged))
    ways = np.array([[_padded(person, points) for person in crowd] for crowd in crowds])
    parked = np.array([[*one.boxes, *[NO_BOX] * (boxes - len(one.boxes))] for one in staged])
    x, y, along, time = np.moveaxis(ways, (3, 2, 1, 0), (0, 1, 2, 3)).astype(np.float32)

    def of_people(name: str, kind: type = np.float32) -> np.ndarray:
        return np.array([[getattr(person, name) for person in crowd] for crowd in crowds], kind).T

    of_cars = {
        name: np.array([getattr(one, name) for one in staged], np.float32) for name in ("start", "speed", "limit")
    }
    return {
        **of_cars,
        **{"path_x": x, "path_y": y, "path_along": along},
        "path_time": time if time.any() else None,
        **{name: of_people(name) for name in ("pace", "run_up", "kerb", "waits_for", "place")},
        "trigger": of_people("trigger", np.int32),
        "boxes": np.moveaxis(parked, 0, -1).astype(np.float32),
    }


def _padded(person: StagedPerson, points: int) -> np.ndarray:
    """Return x, y, metres along the way and times (point, 4), the last point repeated."""
    times = person.times or np.zeros(len(person.way.points))
    table = np.column_stack([person.way.points, person.way.along, times])
    return np.concatenate([table, np.repeat(table[-1:], points - len(table), axis=0)])
