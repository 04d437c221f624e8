"""A drawing of one episode of an evaluation."""

from __future__ import annotations

from pathlib import Path

from jaxwalk.evaluation import replay
from jaxwalk.interfaces import Policy
from jaxwalk.maps import RoadMap
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.viewer import EpisodeFigure, ViewerError, animation, picture

MOVING = (".gif", ".mp4")
"""Endings of files that show the whole episode; other files show its last frame."""


def draw_episode(
    street: Street,
    driver: Policy,
    pedestrians: Policy,
    path: Path,
    *,
    scenario: int,
    seed: int,
    time: float | None = None,
) -> Trajectory:
    """Play a scenario as an evaluation does, and write a picture or an animation of it.

    ``time`` is the moment that a picture shows [s]; by default the end. Raises ViewerError if it is after the end.
    """
    trajectory = replay(street, {"driver": driver, "pedestrian": pedestrians}, Drawn(street, seed), [scenario])
    ground = map_of(street, scenario=scenario, seed=seed)
    if path.suffix.lower() in MOVING:
        animation(EpisodeFigure(trajectory, 0, ground, width=640), path)
    else:
        end = float(trajectory.length[0]) * trajectory.dt
        if time is not None and time > end:
            raise ViewerError(f"at {time:g} s the episode is over: it takes {end:.1f} s")
        frame = None if time is None else round(time / trajectory.dt)
        picture(EpisodeFigure(trajectory, 0, ground), path, frame=frame)
    return trajectory


def map_of(street: Street, *, scenario: int, seed: int) -> RoadMap:
    """Return the map of a scenario, on its own (not in a stack)."""
    import jax
    import numpy as np

    drawn, _ = Drawn(street, seed).take(np.array([scenario]))
    index = int(drawn.map[0])
    return jax.device_get(jax.tree.map(lambda x: x[index], street.world.maps))
