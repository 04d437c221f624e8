"""Hand-made trajectories: a car and people moving straight, with exactly the events a test needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Ghosts, Trajectory

DT = 0.1
DISC = SimConfig(car_length=1e-300, car_width=1e-300, body_radius=1.5)
"""Rules of a car that is a point and people of 1.5 m radius: numbers by footprint are then easy to work out by hand."""
PADDED = ("car_x", "car_y", "car_cos", "car_sin", "car_speed", "car_acceleration")
PLACES = ("ped_x", "ped_y", "ped_vx", "ped_vy", "on_roadway", "on_crosswalk")
CHOICES = ("at_kerb", "enters_roadway", "going", "predicted_miss")
PADDED_PEDS = (*PLACES, "crossing", "decisions", *CHOICES)


@dataclass(frozen=True)
class Walk:
    """Somebody who starts at (x, y) and keeps a velocity; ``crossings`` are (first frame, last frame, type)."""

    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0
    crossings: Sequence[tuple[int, int, int]] = ()
    tau: float = 0.5
    kerb: Sequence[int] = ()
    """Frames at the kerb, about to enter a roadway."""
    waits: Sequence[int] = ()
    """Frames to which a wait led."""
    miss: float = 10.0
    """Predicted, in every frame [m]."""


@dataclass(frozen=True)
class Scene:
    """An episode of ``length`` steps; the car starts at (x, 0) and drives east."""

    length: int
    people: Sequence[Walk]
    x: float = 0.0
    speed: float | Sequence[float] = 5.0
    """Of all frames, or of each."""
    acceleration: dict[int, float] = field(default_factory=dict)
    """Commands by frame; 0 elsewhere."""
    goal: bool = False
    touched: Sequence[int] = ()


def trajectory(*scenes: Scene, scenario: Sequence[int] | None = None) -> Trajectory:
    """The scenes as one trajectory, padded to the longest."""
    frames = max(scene.length for scene in scenes) + 1
    cars = [_car(scene, frames) for scene in scenes]
    people = [[_person(walk, frames) for walk in scene.people] for scene in scenes]
    n = len(scenes)
    touched = np.array([[p in s.touched for p in range(len(s.people))] for s in scenes])
    return Trajectory(
        dt=DT,
        scenario=np.arange(n) if scenario is None else np.array(scenario),
        length=np.array([s.length for s in scenes]),
        goal=np.array([s.goal for s in scenes]),
        collision=touched.any(axis=1),
        touched=touched,
        goal_x=np.zeros(n),
        goal_y=np.zeros(n),
        jaywalking_tendency=np.array([[w.tau for w in s.people] for s in scenes]),
        **{name: np.stack([car[name] for car in cars], axis=1) for name in PADDED},
        **{
            name: np.stack([np.stack([p[name] for p in row], axis=1) for row in people], axis=1) for name in PADDED_PEDS
        },
    )


def _car(scene: Scene, frames: int) -> dict[str, np.ndarray]:
    speed = np.broadcast_to(np.array(scene.speed, float), (scene.length + 1,))
    speed = np.pad(speed, (0, frames - len(speed)), mode="edge")
    command = np.zeros(frames)
    for frame, value in scene.acceleration.items():
        command[frame] = value
    x = scene.x + DT * np.concatenate([[0.0], np.cumsum(speed[1:])])
    zero = np.zeros(frames)
    return dict(zip(PADDED, (x, zero, zero + 1, zero, speed, command), strict=True))


def _person(walk: Walk, frames: int) -> dict[str, np.ndarray]:
    frame = np.arange(frames)
    on, on_crosswalk = np.zeros((2, frames), bool)
    crossing, decisions = np.zeros((2, frames), int)
    for first, last, kind in walk.crossings:
        here = (frame >= first) & (frame <= last)
        on |= here
        on_crosswalk |= here & (kind == CROSSWALK)
        decided = (frame >= max(first - 1, 0)) & (frame <= last)
        crossing[decided] = kind
        decisions[frame >= max(first - 1, 0)] += 1
    x, y = walk.x + DT * walk.vx * frame, walk.y + DT * walk.vy * frame
    vx, vy = np.where(frame > 0, walk.vx, 0.0), np.where(frame > 0, walk.vy, 0.0)
    at_kerb, waits = np.isin(frame, walk.kerb), np.isin(frame, walk.waits)
    choices = (at_kerb, at_kerb, ~waits, np.full(frames, walk.miss))
    values = (x, y, vx, vy, on, on_crosswalk, crossing, decisions, *choices)
    return dict(zip(PADDED_PEDS, values, strict=True))


def random_trajectory(seed: int, *, episodes: int, frames: int, people: int) -> Trajectory:
    """Nonsense on a coarse grid, so that ties and the edges of bins and thresholds come up often."""
    rng = np.random.default_rng(seed)
    many, each = (frames, episodes), (frames, episodes, people)
    length = rng.integers(1, frames, episodes)
    touched = rng.random((episodes, people)) < 0.15
    collision = touched.any(axis=1)
    on = rng.random(each) < 0.85
    east = rng.random(many) < 0.5
    return Trajectory(
        dt=DT,
        scenario=rng.permutation(episodes) + 100,
        length=length,
        goal=~collision & (rng.random(episodes) < 0.5),
        collision=collision,
        touched=touched,
        goal_x=np.zeros(episodes),
        goal_y=np.zeros(episodes),
        car_x=rng.integers(0, 12, many).astype(float),
        car_y=rng.integers(0, 12, many).astype(float),
        car_cos=east.astype(float),
        car_sin=(~east).astype(float),
        car_speed=rng.integers(0, 5, many) * 0.5,
        car_acceleration=rng.choice([-2.0, -1.0, 0.0, 1.0], many, p=[0.4, 0.3, 0.2, 0.1]),
        jaywalking_tendency=rng.integers(0, 9, (episodes, people)) / 8,
        ped_x=rng.integers(0, 24, each).astype(float),
        ped_y=rng.integers(0, 24, each).astype(float),
        ped_vx=rng.integers(-2, 3, each).astype(float),
        ped_vy=rng.integers(-2, 3, each).astype(float),
        on_roadway=on,
        on_crosswalk=on & (rng.random(each) < 0.5),
        crossing=rng.choice([0, CROSSWALK, JAYWALK], (1, episodes, people)) * np.ones(each, int),
        decisions=np.cumsum(rng.random(each) < 0.2, axis=0),
        at_kerb=rng.random(each) < 0.8,
        enters_roadway=rng.random(each) < 0.8,
        going=rng.random(each) < 0.5,
        predicted_miss=rng.integers(0, 13, each) / 2,
    )


def changed(recorded: Trajectory, **arrays) -> Trajectory:
    """The trajectory with some arrays replaced."""
    return replace(recorded, **arrays)


def pick(recorded: Trajectory, *, episodes=slice(None), people=slice(None)) -> Trajectory:
    """Some episodes, or pedestrians, in the given order."""
    known = {f.name: getattr(recorded, f.name) for f in fields(recorded) if f.name != "dt"}
    arrays = {name: array for name, array in known.items() if array is not None}
    for name, array in arrays.items():
        array = array[:, episodes] if name in (*PADDED, *PADDED_PEDS) else array[episodes]
        if name in PADDED_PEDS or name in ("touched", "jaywalking_tendency"):
            array = array[..., people]
        arrays[name] = array
    return changed(recorded, **arrays)


def padded(recorded: Trajectory, frames: int) -> Trajectory:
    """The trajectory with more frames at its end, full of things that must not be seen."""
    arrays = {}
    for name in (*PADDED, *PADDED_PEDS):
        array = getattr(recorded, name)
        rubbish = np.ones((frames, *array.shape[1:]), array.dtype) * (-2 if name == "car_acceleration" else 1)
        arrays[name] = np.concatenate([array, rubbish.astype(array.dtype)])
    return changed(recorded, **arrays)


def ghosts_of(recorded: Trajectory) -> Ghosts:
    """The people of a trajectory as ghosts."""
    return Ghosts(**{field.name: getattr(recorded, field.name) for field in fields(Ghosts)})


def turned(recorded: Trajectory, quarters: int) -> Trajectory:
    """The scene turned to the left by quarters of a turn."""
    pairs = (("goal_x", "goal_y"), ("car_x", "car_y"), ("car_cos", "car_sin"), ("ped_x", "ped_y"), ("ped_vx", "ped_vy"))
    for _ in range(quarters):
        turn = {a: -getattr(recorded, b) for a, b in pairs} | {b: getattr(recorded, a) for a, b in pairs}
        recorded = changed(recorded, **turn)
    return recorded
