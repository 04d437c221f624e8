"""The critical moment of an episode: the contact of the moving car, or else where it came nearest to somebody."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.evaluation.counterfactual import first_seen_frame
from jaxwalk.metrics.crossings import real_frames
from jaxwalk.metrics.footprint import in_car_frame
from jaxwalk.metrics.outcomes import measure_outcomes
from jaxwalk.search.grid import NEAR, cells_of
from jaxwalk.sim.crossing_kind import ContactKind
from jaxwalk.sim.environment import Street
from jaxwalk.sim.events import contact_gap
from jaxwalk.sim.trajectory import Trajectory

BESIDE = 3.0
"""People off the roadway count as this much farther away [m]: cars pass many of them closely, which is no near miss."""
STANDS = 0.1
"""A car slower than this stands: it never arrives [m/s]."""
NOWHERE = -1
"""The cell of an episode in which nobody came near."""


@dataclass(frozen=True, eq=False)
class CriticalMoments:
    """One row per episode."""

    failed: Bool[np.ndarray, "episode"]
    """Whether the moving car touched somebody, by the world's contact."""
    gap: Float[np.ndarray, "episode"]
    """What was missing to a contact at the nearest moment [m], more for people off the roadway; 0 where it failed,
    infinite where there was nobody."""
    ped: Int[np.ndarray, "episode"]
    """The person."""
    frame: Int[np.ndarray, "episode"]
    seen: Int[np.ndarray, "episode"]
    """The first frame in which the car perceived the person; at the latest that one."""
    contact: Int[np.ndarray, "episode"]
    """The `ContactKind`; none where it didn't fail."""
    speed: Float[np.ndarray, "episode"]
    """The car's speed then [m/s]."""
    time: Float[np.ndarray, "episode"]
    """Time to collision when the person was first visible: the car's way from there to the critical moment, divided by
    its speed there [s]; infinite for a car that stood."""
    bearing: Float[np.ndarray, "episode"]
    """Where the person is at the critical moment, from the car's centre, positive to the left [rad]."""
    cell: Int[np.ndarray, "episode"]
    """The cell of the grid, or `NOWHERE`."""

    @property
    def score(self) -> Float[np.ndarray, "episode"]:
        """Return minus the gap: 0 for a failure, below 0 otherwise."""
        return np.where(self.failed, 0.0, -self.gap)

    def some(self, rows: slice | np.ndarray) -> CriticalMoments:
        """Return the rows of a slice, indices or a mask."""
        return CriticalMoments(*(getattr(self, field.name)[rows] for field in fields(self)))

    @staticmethod
    def joined(parts: list[CriticalMoments]) -> CriticalMoments:
        """Return all rows of several parts."""
        names = [field.name for field in fields(CriticalMoments)]
        return CriticalMoments(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def critical_moments(street: Street, played: Trajectory) -> CriticalMoments:
    """Return the critical moment of each episode of a trajectory."""
    config, episodes = street.config, np.arange(len(played.length))
    outcomes = measure_outcomes(played, moving_speed=config.moving_speed)
    nearest, gap = _nearest(played, street)
    failed = outcomes.moving
    frame = np.where(failed, outcomes.steps, nearest[0])
    ped = np.where(failed, outcomes.contact_ped, nearest[1])
    contact = np.where(failed, outcomes.contact, ContactKind.NONE)
    seen = first_seen_frame(street, played, ped, frame)
    way = np.zeros(played.car_x.shape)
    way[1:] = np.hypot(np.diff(played.car_x, axis=0), np.diff(played.car_y, axis=0)).cumsum(axis=0)
    speed = played.car_speed[seen, episodes].astype(np.float64)
    time = np.divide(
        way[frame, episodes] - way[seen, episodes], speed, out=np.full(len(seen), np.inf), where=speed >= STANDS
    )
    bearing = np.arctan2(*reversed(in_car_frame(played, frame, episodes, ped))).astype(np.float64)
    at_contact = played.car_speed[frame, episodes].astype(np.float64)
    cell = cells_of(contact, at_contact, time, bearing)
    gap = np.where(failed, 0.0, gap)
    return CriticalMoments(
        failed=failed,
        gap=gap,
        ped=ped.astype(np.int64),
        frame=frame.astype(np.int64),
        seen=seen.astype(np.int64),
        contact=contact.astype(np.int64),
        speed=at_contact,
        time=time,
        bearing=bearing,
        cell=np.where(failed | (gap <= NEAR), cell, NOWHERE),
    )


def _nearest(played: Trajectory, street: Street) -> tuple[tuple[np.ndarray, np.ndarray], Float[np.ndarray, "episode"]]:
    """Return frame and person at which the moving car came nearest to somebody in each episode, and the gap [m]."""
    config = street.config
    dx, dy = played.ped_x - played.car_x[..., None], played.ped_y - played.car_y[..., None]
    gaps = contact_gap(config, dx, dy, played.car_cos[..., None], played.car_sin[..., None]).astype(np.float64)
    gaps += BESIDE * ~played.on_roadway
    moving = real_frames(played) & (played.car_speed >= config.moving_speed)
    gaps = np.where(moving[..., None], gaps, np.inf).swapaxes(0, 1)  # episode, frame, ped
    flat = gaps.reshape(len(gaps), -1)
    place = flat.argmin(axis=1)
    return np.divmod(place, gaps.shape[2]), flat[np.arange(len(flat)), place]
