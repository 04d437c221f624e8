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
import scipy
from jaxtyping import Bool, Float

from jaxwalk.experiments.real_recordings import Watched
from jaxwalk.formats.clip_grounds import ClipGrounds
from jaxwalk.formats.recordings import cars_in_view
from jaxwalk.formats.tracks import TracksError
from jaxwalk.formats.vci import PEOPLE, read_vci
from jaxwalk.metrics.path_meetings import PATH_MEETINGS, PathMeetings
from jaxwalk.metrics.statistics import episode_draws, interval
from jaxwalk.sim.sim_config import SimConfig

CAR_SPEEDS = 0.75
"""A calibrated world's car is no faster than real ones that move are for this share of their time."""
RISE = 1e-9
"""Accepted gaps that are longer by less than this share of the spread are equally long: the rest is rounding."""


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

    They are NaN where no finite curve that rises is likeliest: `why_no_curve` says why.
    """
    if why_no_curve(gaps, accepted):
        return np.nan, np.nan
    middle, spread = float(gaps.mean()), float(gaps.std())
    scaled = (gaps - middle) / spread
    sign = np.where(accepted, 1.0, -1.0)

    def unlikeliness(curve: np.ndarray) -> tuple[float, np.ndarray]:
        odds = sign * (curve[0] - curve[1] * scaled)
        slope = sign * scipy.special.expit(odds)
        return float(np.logaddexp(0.0, odds).sum()), np.array([slope.sum(), -(slope * scaled).sum()])

    # The scaled problem is convex, and as steep in both directions, whatever the unit and the origin of the gaps.
    share = float(accepted.mean())
    found = scipy.optimize.minimize(unlikeliness, np.array([np.log(1 / share - 1), 0.0]), method="BFGS", jac=True)
    per_second = float(found.x[1]) / spread
    return float(found.x[0]) + per_second * middle, per_second


def why_no_curve(gaps: Float[np.ndarray, "gap"], accepted: Bool[np.ndarray, "gap"]) -> str | None:
    """Return why no finite rising curve of offered gaps [s] is likeliest; None if there is one.

    The likeliest curve rises exactly if accepted gaps are longer on average: at the best flat one, the likelihood's
    slope is their sum less its expectation.
    """
    yes, no = gaps[accepted], gaps[~accepted]
    if not len(gaps):
        return "nobody had a gap to judge"
    if not len(yes) or not len(no):
        return f"{'nobody' if len(no) else 'everybody'} accepted one, of {len(gaps)} in all"
    if min(yes) >= max(no):
        return f"{min(yes):.2f} s parts the {len(yes)} accepted ones from the {len(no)} others, so the curve is a step"
    if yes.mean() - no.mean() <= RISE * gaps.std():
        return f"accepted ones are no longer than others on average ({yes.mean():.2f} s, {no.mean():.2f} s)"
    return None


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
    if reason := why_no_curve(table.offered[judged], (table.pet > 0)[judged]):
        raise TracksError(f"these recordings fit no curve of accepted gaps: {reason}; give more of them")
    names = (*asdict(fits[0]), "critical")
    return {
        "meetings": len(judged),
        "judged": int(judged.sum()),
        "accepted": int((table.pet > 0)[judged].sum()),
        "approach_seen": _approach_seen(table),
        **{name: asdict(interval(np.array([getattr(fit, name) for fit in fits]), int(judged.sum()))) for name in names},
    }


def _approach_seen(table: PathMeetings) -> dict[str, Any]:
    """Return the curve of only those people that the recording shows where they judge; None where there is none."""
    chosen = ~np.isnan(table.offered) & table.approach_seen
    accepted = (table.pet > 0)[chosen]
    curve = fit_gap_acceptance(table.offered[chosen], accepted)
    numbers = {"intercept": curve[0], "per_second": curve[1], "critical": curve[0] / curve[1]}
    fitted = {name: None if np.isnan(value) else value for name, value in numbers.items()}
    return {"judged": len(accepted), "accepted": int(accepted.sum()), **fitted}


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
