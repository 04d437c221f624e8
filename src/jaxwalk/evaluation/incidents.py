"""Find the failures of an evaluation that are worth watching: collisions and nearest misses, the worst first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from jaxwalk.metrics import ENCOUNTERS, OUTCOMES, SURROGATES, Rows
from jaxwalk.metrics.injury import monfort_mueller_mais3
from jaxwalk.metrics.surrogate import TTC_CRITICAL
from jaxwalk.sim.events import distance
from jaxwalk.sim.trajectory import Trajectory

BEFORE = 2.0
"""What the car was doing is judged by the time since this long before the incident [s]."""
WALKED = 1.0
"""Where the pedestrian came from is judged by the time since this long before the incident [s]."""
TURN = np.radians(20)
"""A larger change of heading is a turn [rad]."""
ACROSS = 0.3
"""A pedestrian who moves across the car's heading faster than this comes from a side [m/s]."""


@dataclass(frozen=True)
class Incidents:
    """One row per incident, the worst first: collisions by risk of injury, then near misses by time to collision."""

    scenario: Int[np.ndarray, "incident"]
    ped: Int[np.ndarray, "incident"]
    """The pedestrian who was hit or nearly hit."""
    collision: Bool[np.ndarray, "incident"]
    """Whether it was a collision; else it was a near miss."""
    contact: Int[np.ndarray, "incident"]
    """CROSSWALK, JAYWALK or SIDEWALK: what the pedestrian was doing."""
    moving: Bool[np.ndarray, "incident"]
    """Whether a moving car hit the pedestrian; false for somebody who walked into a standing car."""
    speed: Float[np.ndarray, "incident"]
    """Speed of the car at impact [m/s]; NaN for a near miss."""
    risk: Float[np.ndarray, "incident"]
    """Risk of a serious injury or death (Monfort and Mueller, 2025); 0 if the car stood, NaN for a near miss."""
    ttc: Float[np.ndarray, "incident"]
    """Smallest time to collision of a near miss [s], below `TTC_CRITICAL`; NaN for a collision."""
    nearest: Float[np.ndarray, "incident"]
    """Smallest gap between car and body in a near miss [m]; NaN for a collision."""
    first: Int[np.ndarray, "incident"]
    """First frame of a near miss; the frame of a collision."""
    last: Int[np.ndarray, "incident"]
    """Last frame of a near miss; the frame of a collision."""

    def some(self, which: slice) -> Incidents:
        """Return some of the incidents."""
        return Incidents(**{name: column[which] for name, column in vars(self).items()})


def find_incidents(rows: Rows, *, most: int) -> Incidents:
    """Find the ``most`` worst collisions, and as many of the nearest misses (with critical time to collision).

    There is one incident for each scenario.

    Raises:
        ValueError: ``most`` is negative.
    """
    if most < 0:
        raise ValueError(f"most must be 0 or more, not {most}")
    hits, misses = _hits(rows, most), _misses(rows, most)
    return Incidents(**{name: np.concatenate([column, getattr(misses, name)]) for name, column in vars(hits).items()})


def _hits(rows: Rows, most: int) -> Incidents:
    table = rows[OUTCOMES]
    risk = np.where(table.moving, monfort_mueller_mais3(np.nan_to_num(table.impact_speed)), 0.0)
    hit = np.flatnonzero(table.collision)
    worst = hit[np.lexsort((table.scenario[hit], -risk[hit]))][:most]
    nothing = np.full(len(worst), np.nan)
    return Incidents(
        scenario=table.scenario[worst], ped=table.contact_ped[worst], collision=table.collision[worst],
        contact=table.contact[worst], moving=table.moving[worst], speed=table.impact_speed[worst].astype(float),
        risk=risk[worst], ttc=nothing, nearest=nothing, first=table.steps[worst], last=table.steps[worst],
    )  # fmt: skip


def _misses(rows: Rows, most: int) -> Incidents:
    found, ttc = rows[ENCOUNTERS], rows[SURROGATES].ttc
    missed = np.flatnonzero(~rows[OUTCOMES].collision[found.episode])
    missed = missed[ttc[missed] < TTC_CRITICAL]
    order = missed[np.lexsort((found.scenario[missed], found.min_gap[missed], ttc[missed]))]
    _, first = np.unique(found.scenario[order], return_index=True)
    worst = order[np.sort(first)][:most]
    nothing = np.full(len(worst), np.nan)
    return Incidents(
        scenario=found.scenario[worst], ped=found.ped[worst], collision=np.zeros(len(worst), bool),
        contact=found.type[worst], moving=np.zeros(len(worst), bool), speed=nothing, risk=nothing,
        ttc=ttc[worst].astype(float), nearest=found.min_gap[worst].astype(float), first=found.start[worst],
        last=found.end[worst],
    )  # fmt: skip


@dataclass(frozen=True)
class Situations:
    """How each incident happened, in words; incidents with the same words are of the same kind."""

    frame: Int[np.ndarray, "incident"]
    """Frame of the contact, or of the nearest moment of a near miss."""
    car: Shaped[np.ndarray, "incident"]
    """``standing``, ``going straight``, ``turning left`` or ``turning right``."""
    side: Shaped[np.ndarray, "incident"]
    """Where the pedestrian came from, as seen from the car: ``from the left``, ``from the right``, ``along the way`` or
    ``standing``."""


def describe(incidents: Incidents, trajectory: Trajectory, *, moving_speed: float) -> Situations:
    """Describe how incidents happened. A car moves if it drives at ``moving_speed`` [m/s] or more.

    Raises:
        ValueError: the trajectory lacks an incident's scenario.
    """
    places = {int(number): place for place, number in enumerate(trajectory.scenario)}
    if lost := [int(number) for number in incidents.scenario if int(number) not in places]:
        raise ValueError(f"the trajectory lacks scenario {lost[0]}")
    e = np.array([places[int(number)] for number in incidents.scenario], int)
    rows = np.stack([e, incidents.ped, incidents.first, incidents.last], axis=1).tolist()
    frame = np.array([_nearest(trajectory, *row) for row in rows], int)
    return Situations(
        frame=frame,
        car=_doing(trajectory, e, frame, moving_speed),
        side=_coming(trajectory, e, incidents.ped, frame),
    )


def _nearest(t: Trajectory, episode: int, ped: int, first: int, last: int) -> int:
    """Return the frame from ``first`` to ``last`` in which the pedestrian is nearest to the car."""
    frames = slice(first, last + 1)
    away = distance(
        t.ped_x[frames, episode, ped] - t.car_x[frames, episode],
        t.ped_y[frames, episode, ped] - t.car_y[frames, episode],
    )
    return int(first + np.argmin(away))


def _doing(t: Trajectory, episode: np.ndarray, frame: np.ndarray, moving_speed: float) -> np.ndarray:
    """Return what the car is doing."""
    before = np.maximum(frame - round(BEFORE / t.dt), 0)
    heading = np.arctan2(t.car_sin, t.car_cos)
    turned = heading[frame, episode] - heading[before, episode]
    turned = (turned + np.pi) % (2 * np.pi) - np.pi
    stands = t.car_speed[frame, episode] < moving_speed
    return np.select(
        [stands, turned > TURN, turned < -TURN], ["standing", "turning left", "turning right"], "going straight"
    )


def _coming(t: Trajectory, episode: np.ndarray, ped: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Return where the pedestrian comes from."""
    before = np.maximum(frame - round(WALKED / t.dt), 0)
    time = np.maximum(frame - before, 1) * t.dt
    vx = (t.ped_x[frame, episode, ped] - t.ped_x[before, episode, ped]) / time
    vy = (t.ped_y[frame, episode, ped] - t.ped_y[before, episode, ped]) / time
    leftward = vy * t.car_cos[frame, episode] - vx * t.car_sin[frame, episode]
    return np.select(
        [distance(vx, vy) < ACROSS, leftward < -ACROSS, leftward > ACROSS],
        ["standing", "from the left", "from the right"], "along the way",
    )  # fmt: skip
