"""Take pictures of an episode that is played from outside."""

from __future__ import annotations

import equinox as eqx
import numpy as np
from jaxtyping import Bool, UInt8

from jaxwalk.adapters.game import EVENTS
from jaxwalk.maps import as_network
from jaxwalk.rollout import Stream
from jaxwalk.sim import vehicle
from jaxwalk.sim.environment import Street
from jaxwalk.sim.recording import frame, parked_boxes
from jaxwalk.sim.trajectory import Trajectory, in_order
from jaxwalk.viewer import EpisodeFigure

WIDTH = 640
"""Width of a picture in pixels."""

_frame = eqx.filter_jit(frame)
_goal = eqx.filter_jit(vehicle.goal)


class Camera:
    """Record an episode step by step, and draw its current frame."""

    def __init__(self, street: Street, *, width: int = WIDTH) -> None:
        """Prepare to record; ``width`` is that of the pictures in pixels."""
        self.street, self.width = street, width
        self.trajectory: Trajectory | None = None
        self.figure: EpisodeFigure | None = None

    def begin(self, stream: Stream) -> None:
        """Start recording at an episode's first frame; ``stream`` holds one environment."""
        row, scenario = self._row(stream), stream.scenario
        frames = self.street.world.rules.horizon + 1
        goal_x, goal_y = _goal(self.street.world, scenario)
        self.trajectory, self.figure = (
            Trajectory(
                dt=self.street.world.rules.dt,
                scenario=np.asarray(stream.episode),
                length=np.zeros(1, np.int32),
                goal=np.zeros(1, bool),
                collision=np.zeros(1, bool),
                touched=np.zeros((1, self.street.world.rules.pedestrians), bool),
                goal_x=np.asarray(goal_x),
                goal_y=np.asarray(goal_y),
                jaywalking_tendency=np.asarray(scenario.jaywalking_tendency(self.street.world)).T,
                parked=parked_boxes(self.street.world, scenario),
                **{name: np.zeros((frames, *x.shape), x.dtype) for name, x in row.items()},
            ),
            None,
        )
        self._write(0, row)
        self.map_index = int(scenario.map[0])

    def add(self, stream: Stream, events: Bool[np.ndarray, "event env"]) -> None:
        """Record the frame after a step; ``events`` are in the order of `EVENTS`."""
        if self.trajectory is None:
            raise RuntimeError("the camera has seen no beginning")
        now = int(stream.state.step[0])
        self._write(now, self._row(stream))
        self.trajectory.length[0] = now
        happened = dict(zip(EVENTS, events, strict=True))
        self.trajectory.goal[:], self.trajectory.collision[:] = happened["goal"], happened["collision"]

    def picture(self) -> UInt8[np.ndarray, "height width 3"]:
        """Return a picture of the last frame."""
        if self.trajectory is None:
            raise RuntimeError("the camera has seen no beginning")
        if self.figure is None:
            network = as_network(self.street.maps[self.map_index])
            self.figure = EpisodeFigure(self.trajectory, 0, network, width=self.width)
        self.figure.refresh()
        return self.figure.pixels(self.figure.last)

    def _row(self, stream: Stream) -> dict[str, np.ndarray]:
        """Return a moment as the rows of a `Trajectory`."""
        seen = _frame(self.street.world, stream.scenario, stream.state)
        return in_order({name: np.asarray(x) for name, x in seen.items()})

    def _write(self, at: int, row: dict[str, np.ndarray]) -> None:
        for name, value in row.items():
            getattr(self.trajectory, name)[at] = value
