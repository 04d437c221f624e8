"""People calibrated on recordings: which gaps they accept, and how fast they walk, fitted to what a camera saw.

The gaps by maximum likelihood, as P(accept) = 1 / (1 + exp(intercept - per_second x gap)), the form of Brewer et al.
(2006); the pace as the even range that is nearest to the crossing speeds seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import minimize

from jaxwalk.experiments.real_recordings import Watched
from jaxwalk.formats.clip_grounds import ClipGrounds
from jaxwalk.formats.recordings import cars_in_view
from jaxwalk.formats.tracks import TracksError
from jaxwalk.formats.vci import PEOPLE, read_vci
from jaxwalk.metrics.path_meetings import PATH_MEETINGS
from jaxwalk.metrics.statistics import episode_draws, interval
from jaxwalk.sim.sim_config import SimConfig

CAR_SPEEDS = 0.75
"""A calibrated world's car is no faster than real ones that move are for this share of their time."""


@dataclass(frozen=True)
class FittedPeople:
    """What is fitted to meetings of ways and paths."""

    intercept: float
    per_second: float
    """How fast gaps become more acceptable [1/s]."""
    slowest: float
    """Pace of the slowest person [m/s]."""
    fastest: float
    """Pace of the fastest person [m/s]."""

    @property
    def critical(self) -> float:
        """The gap that one half accept [s]."""
        return self.intercept / self.per_second


def fit_gap_acceptance(gaps: Float[np.ndarray, "gap"], accepted: Bool[np.ndarray, "gap"]) -> tuple[float, float]:
    """Return intercept and slope [1/s] of the likeliest logistic curve of offered gaps [s].

    They are NaN where no finite curve is likeliest: where nobody or everybody accepts, or some gap parts the two.
    """
    yes, no = gaps[accepted], gaps[~accepted]
    if not len(yes) or not len(no) or min(yes) >= max(no) or min(no) >= max(yes):
        return np.nan, np.nan
    sign = np.where(accepted, 1.0, -1.0)

    def unlikeliness(curve: np.ndarray) -> float:
        return float(np.logaddexp(0.0, sign * (curve[0] - curve[1] * gaps)).sum())

    found = minimize(unlikeliness, np.array([0.0, 0.0]), method="BFGS")
    return float(found.x[0]), float(found.x[1])


def fit_pace(speeds: Float[np.ndarray, "person"]) -> tuple[float, float]:
    """Return the ends of the even range nearest to speeds: least squares of the quantiles, that is Wasserstein-2.

    They are NaN for fewer than two speeds.
    """
    if len(speeds) < 2:
        return np.nan, np.nan
    places = (np.arange(len(speeds)) + 0.5) / len(speeds)
    width, low = np.polyfit(places, np.sort(speeds), 1)
    return float(low), float(low + width)


def fit_people(watched: Watched) -> dict[str, Any]:
    """Return what is fitted to recordings, with 95 % intervals over recordings, ready for JSON.

    Raises TracksError if the gaps fit no curve.
    """
    table = watched.rows[PATH_MEETINGS]
    judged = ~np.isnan(table.offered)
    _, times = next(iter(episode_draws(watched.recordings)))
    drawn = [np.repeat(np.arange(len(judged)), np.nan_to_num(row).astype(int)[watched.of_meeting]) for row in times]
    fits = [_fit(watched, rows) for rows in drawn]
    if np.isnan(fits[0].intercept):
        raise TracksError("these recordings say nothing about gaps: some gap parts those accepted from all others")
    names = (*asdict(fits[0]), "critical")
    return {
        "meetings": len(judged),
        "judged": int(judged.sum()),
        "accepted": int((table.pet > 0)[judged].sum()),
        **{name: asdict(interval(np.array([getattr(fit, name) for fit in fits]), int(judged.sum()))) for name in names},
    }


def _fit(watched: Watched, rows: np.ndarray) -> FittedPeople:
    """Fit people to some meetings, of which there may be several copies."""
    table = watched.rows[PATH_MEETINGS]
    gaps, accepted = table.offered[rows], table.pet[rows] > 0
    judged = ~np.isnan(gaps)
    return FittedPeople(*fit_gap_acceptance(gaps[judged], accepted[judged]), *fit_pace(table.crossing_speed[rows]))


def car_speed(folder: Path, grounds: ClipGrounds, names: Sequence[str]) -> float:
    """Return the speed that cars which move at some time exceed for a quarter of their time in view [m/s]."""

    def speeds() -> Iterator[np.ndarray]:
        for name in names:
            tracks = read_vci(folder / f"{name}{PEOPLE}", frame_rate=grounds.frame_rate)
            for view in cars_in_view(tracks, SimConfig()):
                yield np.hypot(tracks.vx[view.car], tracks.vy[view.car])

    return float(np.quantile(np.concatenate(list(speeds())), CAR_SPEEDS))
