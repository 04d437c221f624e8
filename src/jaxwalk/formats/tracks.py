"""Trajectories as a table with a row for each road user and moment, from any source (``docs/trajectories.md``)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float, Int, Shaped

from jaxwalk.sim.crossing_kind import CrossingKind
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory

CAR, PEDESTRIAN = "car", "pedestrian"
"""Types that are measured. Others, such as ``bicycle``, may be in a table, but the metrics ignore them."""
CAR_LENGTH, CAR_WIDTH, PERSON = SimConfig.car_length, SimConfig.car_width, 2 * SimConfig.body_radius
"""Sizes in the simulator's tables [m]."""
CROSSINGS = tuple(kind.word for kind in CrossingKind)
"""Words for `Trajectory.crossing`, by its number."""
GOAL, COLLISION, TIMEOUT = "goal", "collision", "timeout"
"""Endings of an episode."""

OF_CARS = {"speed": np.nan, "acceleration": np.nan, "goal_x": np.nan, "goal_y": np.nan, "ending": ""}
"""Optional columns of cars, and the value that stands for an empty one."""
OF_PEOPLE = {
    "jaywalking_tendency": np.nan, "on_roadway": False, "on_crosswalk": False, "crossing": CROSSINGS[0], "decisions": 0,
    "at_kerb": False, "enters_roadway": False, "going": True, "predicted_miss": np.nan, "touched": False,
}  # fmt: skip
"""Optional columns of pedestrians, and the value that stands for an empty one."""
OPTIONAL = {**OF_CARS, **OF_PEOPLE}

LARGEST = 1e12
"""Largest time, position or speed in a table; a larger number is a mistake."""
LONGEST_WORD = 1000
"""Longest text in a table [characters; bytes in Parquet], so that a small file can't fill memory."""


class TracksError(ValueError):
    """Trajectories can't be used. The message says why and what to do, in one line."""


@dataclass(frozen=True)
class Tracks:
    """A recording of one place: a row for each road user and moment, in any order."""

    episode: int
    """Number of the recording. For the simulator's episodes, it is the scenario's number."""
    t: Float[np.ndarray, "row"]
    """Time [s]."""
    id: Int[np.ndarray, "row"]
    """Number of the road user."""
    type: Shaped[np.ndarray, "row"]
    """CAR, PEDESTRIAN or another word."""
    x: Float[np.ndarray, "row"]
    """Centre [m]."""
    y: Float[np.ndarray, "row"]
    vx: Float[np.ndarray, "row"]
    """Velocity [m/s]."""
    vy: Float[np.ndarray, "row"]
    heading: Float[np.ndarray, "row"]
    """Heading, counter-clockwise from the x axis [rad]."""
    length: Float[np.ndarray, "row"]
    """Size [m]; metrics read a car's."""
    width: Float[np.ndarray, "row"]
    known: Mapping[str, Shaped[np.ndarray, "row"]]
    """Optional columns that the recording has, by the names in `OPTIONAL`."""


REQUIRED = tuple(field.name for field in fields(Tracks) if field.name != "known")
"""Columns of every table."""
UNITS = {
    "t": "s", "x": "m", "y": "m", "vx": "m/s", "vy": "m/s", "heading": "rad", "length": "m", "width": "m",
    "speed": "m/s", "acceleration": "m/s2", "goal_x": "m", "goal_y": "m", "predicted_miss": "m",
}  # fmt: skip


def tracks_of(trajectory: Trajectory) -> Iterator[Tracks]:
    """Return every episode of a trajectory, with all columns that the metrics need: car 0, pedestrians 1, 2, ..."""
    return (_episode(trajectory, episode) for episode in range(len(trajectory.length)))


def _episode(trajectory: Trajectory, episode: int) -> Tracks:
    """Return one episode: the car's rows, then those of each pedestrian."""
    frames, people = int(trajectory.length[episode]) + 1, trajectory.ped_x.shape[2]
    car = {name: _frames(trajectory, f"car_{name}", frames, episode) for name in ("x", "y", "cos", "sin", "speed")}
    ped = {name: _frames(trajectory, f"ped_{name}", frames, episode) for name in ("x", "y", "vx", "vy")}

    def both(of_car: np.ndarray, of_people: np.ndarray) -> np.ndarray:
        return np.concatenate([of_car, of_people.T.reshape(-1)])

    def constant(of_car: float, of_person: float) -> np.ndarray:
        return both(np.full(frames, of_car), np.full((frames, people), of_person))

    return Tracks(
        episode=int(trajectory.scenario[episode]),
        t=np.tile(np.arange(frames) * trajectory.dt, 1 + people),
        id=np.repeat(np.arange(1 + people), frames),
        type=np.repeat([CAR, PEDESTRIAN], [frames, frames * people]),
        x=both(car["x"], ped["x"]),
        y=both(car["y"], ped["y"]),
        vx=both(car["speed"] * car["cos"], ped["vx"]),
        vy=both(car["speed"] * car["sin"], ped["vy"]),
        # In double precision, so that the car's cosine and sine can be restored exactly.
        heading=both(np.arctan2(car["sin"], car["cos"], dtype=np.float64), _headings(ped["vx"], ped["vy"])),
        length=constant(CAR_LENGTH, PERSON),
        width=constant(CAR_WIDTH, PERSON),
        known=_known(trajectory, episode, frames),
    )


def _frames(trajectory: Trajectory, name: str, frames: int, episode: int) -> np.ndarray:
    """Return the first frames of a column of one episode."""
    return np.asarray(getattr(trajectory, name))[:frames, episode]


def _headings(vx: Float[np.ndarray, "frame ped"], vy: Float[np.ndarray, "frame ped"]) -> Float[np.ndarray, "frame ped"]:
    """Return walking directions [rad]. Standing pedestrians keep the last one, else have the next one, else 0."""
    walks = (vx != 0) | (vy != 0)
    frame = np.arange(len(vx))[:, None]
    last = np.maximum.accumulate(np.where(walks, frame, -1), axis=0)
    source = np.where(last >= 0, last, walks.argmax(axis=0))
    return np.take_along_axis(np.arctan2(vy, vx), source, axis=0)


def _known(trajectory: Trajectory, episode: int, frames: int) -> dict[str, np.ndarray]:
    """Return the optional columns of one episode."""
    people = trajectory.ped_x.shape[2]
    last = (np.arange(frames) == frames - 1)[:, None]
    ending = GOAL if trajectory.goal[episode] else COLLISION if trajectory.collision[episode] else TIMEOUT
    of_car = {
        "speed": _frames(trajectory, "car_speed", frames, episode),
        "acceleration": _frames(trajectory, "car_acceleration", frames, episode),
        **{name: np.full(frames, getattr(trajectory, name)[episode]) for name in ("goal_x", "goal_y")},
        "ending": np.full(frames, ending),
    }
    of_people = {name: _frames(trajectory, name, frames, episode) for name in OF_PEOPLE if name in _RECORDED}
    of_people |= {
        "jaywalking_tendency": np.broadcast_to(trajectory.jaywalking_tendency[episode], (frames, people)),
        "crossing": np.array(CROSSINGS)[of_people["crossing"]],
        "touched": last & trajectory.touched[episode],
    }
    columns = {}
    for name, values in of_car.items():
        columns[name] = np.concatenate([values, np.full(frames * people, OF_CARS[name], values.dtype)])
    for name, values in of_people.items():
        columns[name] = np.concatenate([np.full(frames, OF_PEOPLE[name], values.dtype), values.T.reshape(-1)])
    return columns


_RECORDED = (
    "on_roadway", "on_crosswalk", "crossing", "decisions", "at_kerb", "enters_roadway", "going", "predicted_miss",
)  # fmt: skip
"""Optional columns that a trajectory has for every frame."""
