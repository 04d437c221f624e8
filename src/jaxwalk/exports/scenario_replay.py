"""An exported episode, read back as a scripted test and played: the car drives where it was recorded."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jaxwalk.evaluation.playing import play
from jaxwalk.formats.openscenario import read_openscenario
from jaxwalk.formats.paths import Path as RecordedPath
from jaxwalk.formats.paths import paths
from jaxwalk.formats.tracks import CAR, tracks_of
from jaxwalk.policies import AlwaysGo
from jaxwalk.policies.recorded_drive import RecordedDrive
from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.xosc.script_reading import read_xosc
from jaxwalk.sim.sim_config import WORLDS, SimConfig
from jaxwalk.sim.suites import CRASH_WORLD
from jaxwalk.sim.trajectory import Trajectory

REPLAYED = WORLDS[CRASH_WORLD]
"""The rules by which episodes are played again, if none are given."""


class ReplayedEpisode(NamedTuple):
    """An episode of a file, played again."""

    source: Scripted
    """The scripted test that was read."""
    trajectory: Trajectory
    frames: int
    """Moments that both have: all, unless one of the two ends earlier at a contact."""
    error: float
    """The largest distance between anybody and where the file has them, over these moments [m]."""


def replayed_episode(file: Path, rules: SimConfig = REPLAYED) -> ReplayedEpisode:
    """Return an exported episode as the simulator plays it again from its file, by the rules of a world.

    Raises CrashFileError if the file can't be read as a script, and ValueError if it isn't an episode's.
    """
    script, recorded = read_xosc(file), read_openscenario(file.read_bytes())
    cars = [path for path in recorded.values() if path.type == CAR]
    if len(cars) != 1:
        raise ValueError(f"{file}: {len(cars)} recorded cars; name an episode that jaxwalk scenario wrote")
    source = Scripted.of(script.suite, str(file), track=script.track, rules=replace(rules, substeps=1))
    (car,) = cars
    places = np.stack([car.x, car.y], axis=1) + script.shift
    driver = RecordedDrive.of(car.t, places, source.street.config)
    scenarios, keys = source.take(np.array([0]))
    trajectory = play(source.street, {"driver": driver, "pedestrian": AlwaysGo()}, scenarios, keys)
    played = list(paths(next(tracks_of(trajectory))).values())
    frames = min(len(car.t), len(played[0].t))
    order = [car, *(path for path in recorded.values() if path.type != CAR)]
    error = max(_apart(one, other, script.shift, frames) for one, other in zip(order, played, strict=True))
    return ReplayedEpisode(source, trajectory, frames, error)


def _apart(recorded: RecordedPath, played: RecordedPath, shift: np.ndarray, frames: int) -> float:
    """Return the largest distance of two paths in the first frames but the last, in which a contact may end one [m]."""
    kept = slice(max(frames - 1, 1))
    dx, dy = recorded.x[kept] + shift[0] - played.x[kept], recorded.y[kept] + shift[1] - played.y[kept]
    return float(np.hypot(dx, dy).max())
