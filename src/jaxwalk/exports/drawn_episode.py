"""A drawing of one episode of an evaluation."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from jaxwalk.evaluation import replay
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.maps import as_network
from jaxwalk.maps.network import Network
from jaxwalk.scenarios import Source
from jaxwalk.sim.environment import Street
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.viewer import EpisodeFigure, ViewerError, animation, picture

MOVING = (".gif", ".mp4")
"""Endings of files that show the whole episode; other files show its last frame."""


def draw_episode(
    street: Street, policies: Roles[Policy], source: Source, number: int, path: Path, *, time: float | None = None
) -> Trajectory:
    """Play scenario ``number`` of a source as an evaluation does, and write a picture or an animation of it.

    ``time`` is the moment that a picture shows [s]; by default the end. Raises ViewerError if it is after the end.
    """
    trajectory = replay(street, policies, source, [number])
    ground = network_of_scenario(street, source, number)
    if path.suffix.lower() in MOVING:
        animation(EpisodeFigure(trajectory, 0, ground, width=640), path)
    else:
        end = float(trajectory.length[0]) * trajectory.dt
        if time is not None and time > end:
            raise ViewerError(f"at {time:g} s the episode is over: it takes {end:.1f} s")
        frame = None if time is None else round(time / trajectory.dt)
        picture(EpisodeFigure(trajectory, 0, ground), path, frame=frame)
    return trajectory


def network_of_scenario(street: Street, source: Source, number: int) -> Network:
    """Return the street on which a scenario takes place."""
    scenarios, _ = source.take(np.array([number]))
    return as_network(street.maps[int(scenarios.map[0])])
