"""Surrogate safety: how near an encounter came to a collision, in time and in required braking.

The car is a rectangle, and a pedestrian's body is a disc: they collide when these overlap. Time to collision
(TTC), T2 and required deceleration (DRAC) assume constant velocities; post-encroachment time (PET) is what happened.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.conflict_areas import Steps, conflict_areas, crossing_steps, finite, second_arrivals
from jaxwalk.metrics.counts import clustered_share
from jaxwalk.metrics.crossings import TYPES, ByType, count_by_type
from jaxwalk.metrics.encounters import ENCOUNTERS, Encounters
from jaxwalk.metrics.footprint import required_deceleration, time_to_contact
from jaxwalk.metrics.injury import monfort_mueller_fatal, monfort_mueller_mais3, rosen_sander_fatal
from jaxwalk.metrics.metric import Metric, Rows, Sums, episodes_with
from jaxwalk.metrics.statistics import Estimate, interval, mean_of, quantile, ratio
from jaxwalk.metrics.values import Values, without_nan
from jaxwalk.sim.events import distance
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory

TTC_CRITICAL = 1.5
"""A smaller time to collision is critical [s]: Hydén (1987). ``docs/metrics.md`` says which sources were seen."""
PET_CRITICAL = 1.5
"""A smaller post-encroachment time is critical [s]: Peesapati et al. (2018) ..."""
PET_CLOSE = 3.0
"""... and a smaller one than this still close [s]."""
DRAC_CRITICAL = 3.4
"""A larger required deceleration is critical [m/s2]: Huber et al. (2020)."""


@dataclass(frozen=True)
class Surrogates:
    """One row per encounter, parallel to `Encounters`; NaN stands for a value that does not exist."""

    episode: Int[np.ndarray, "encounter"]
    """Row of the episode."""
    type: Int[np.ndarray, "encounter"]
    """CROSSWALK or JAYWALK."""
    ttc: Float[np.ndarray, "encounter"]
    """Smallest time to collision [s]; 0 after a touch, NaN if they were never on a collision course."""
    exposed_time: Float[np.ndarray, "encounter"]
    """Time with a time to collision below ``TTC_CRITICAL`` [s] (TET; Minderhoud and Bovy, 2001)."""
    pet: Float[np.ndarray, "encounter"]
    """Post-encroachment time [s]: positive if the pedestrian came first, negative if the car did, 0 after a touch; NaN
    if the paths never meet, or one came more than ``PET_LIMIT`` after the other."""
    t2: Float[np.ndarray, "encounter"]
    """Smallest predicted arrival of the second road user [s]; NaN without a conflict area."""
    drac: Float[np.ndarray, "encounter"]
    """Largest required deceleration [m/s2] before any touch; 0 if they were never on a collision course; NaN if they
    touched from the first frame on."""
    impact_speed: Float[np.ndarray, "encounter"]
    """Speed of a moving car that touched the pedestrian, for the injury curves [m/s]; NaN if none did."""
    relative_speed: Float[np.ndarray, "encounter"]
    """Relative speed of car and pedestrian at a touch, also if the car stood [m/s]; NaN without a touch."""


def measure_surrogates(trajectory: Trajectory, encounters: Encounters, config: SimConfig) -> Surrogates:
    """Return the surrogates of all encounters.

    Args:
        trajectory: the trajectory in which the encounters were found.
        encounters: the encounters.
        config: says how large car and body are, and at what speed a car hits somebody who else walks into it.
    """
    steps = crossing_steps(trajectory, encounters)
    met = steps.frame >= encounters.start[steps.encounter]
    relative = _relative(trajectory, steps)
    ttc = np.where(met, time_to_contact(*relative, config), np.inf)
    drac = np.where(met, required_deceleration(ttc, distance(*relative[2:])), np.nan)
    critical = np.add.reduceat((ttc < TTC_CRITICAL).astype(np.int64), steps.first)
    lag, place = conflict_areas(trajectory, encounters, steps, config)
    last = steps.first + (encounters.end - encounters.enter)
    speed = trajectory.car_speed[encounters.end, encounters.episode]
    columns = {
        "ttc": finite(np.minimum.reduceat(ttc, steps.first)),
        "exposed_time": critical * trajectory.dt,
        "pet": lag * trajectory.dt,
        "t2": second_arrivals(trajectory, steps, met, lag, place),
        "drac": np.fmax.reduceat(drac, steps.first),
        "impact_speed": np.where(encounters.collided & (speed >= config.moving_speed), speed, np.nan),
        "relative_speed": np.where(encounters.collided, distance(relative[2], relative[3])[last], np.nan),
    }
    rows = {name: column.astype(np.float32) for name, column in columns.items()}
    return Surrogates(episode=encounters.episode, type=encounters.type, **rows)


def _relative(trajectory: Trajectory, steps: Steps) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return displacement [m] and relative velocity [m/s] from the car to the pedestrian, in the car's frame."""
    car = steps.frame, steps.episode
    cos, sin = (x[car].astype(np.float64) for x in (trajectory.car_cos, trajectory.car_sin))
    ahead, left = to_frame(steps.x - trajectory.car_x[car], steps.y - trajectory.car_y[car], cos, sin)
    closing, aside = to_frame(steps.vx, steps.vy, cos, sin)
    return ahead, left, closing - trajectory.car_speed[car], aside


@dataclass(frozen=True)
class Spread:
    """A measure over encounters; encounters are assumed independent."""

    median: Estimate
    extreme: Estimate
    """The dangerous end: the 5th percentile of times, the 95th of decelerations."""


@dataclass(frozen=True)
class SurrogateSummary:
    """The encounters of one type. Shares are over all encounters."""

    count: int
    ttc: Spread
    """Time to collision [s], over encounters that were ever on a collision course."""
    pet: Spread
    """Post-encroachment time without its sign [s], over encounters with a conflict area."""
    t2: Spread
    """T2 [s], over encounters with a conflict area."""
    drac: Spread
    """Required deceleration [m/s2]."""
    ttc_critical: Estimate
    """Share with a TTC below 1.5 s."""
    pet_critical: Estimate
    """Share with a PET below 1.5 s, whoever came first."""
    pet_close: Estimate
    """Share with a PET below 3 s."""
    drac_critical: Estimate
    """Share with a DRAC above 3.4 m/s2."""
    exposed_time: Estimate
    """Mean time with a TTC below 1.5 s [s]."""
    pedestrian_first: Estimate
    """Share in which the pedestrian came first, among encounters with a conflict area and without a touch."""
    impact_speed: Estimate
    """Mean speed of cars that hit somebody [m/s]. Counts, here and in the risks: pedestrians hit."""
    mais3: Estimate
    """Mean risk of a serious injury or worse for those hit (Monfort and Mueller, 2025)."""
    fatal: Estimate
    """Mean risk of death for those hit (Monfort and Mueller, 2025)."""
    fatal_rosen_sander: Estimate
    """Mean risk of death for those hit, after Rosén and Sander (2009)."""


SHARES = {
    "ttc_critical": "met",
    "pet_critical": "met",
    "pet_close": "met",
    "drac_critical": "met",
    "pedestrian_first": "one_first",
}
"""Shares of the summary, and what each is a share of."""
RISKS = {"mais3": monfort_mueller_mais3, "fatal": monfort_mueller_fatal, "fatal_rosen_sander": rosen_sander_fatal}
"""Mean risks of those hit by a moving car. Their intervals are over those who were hit, and leave out how uncertain the
curves are: the standard errors of their coefficients were not at hand (``docs/metrics.md``)."""


def surrogate_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return, per episode and type, the sums behind every share and mean of the summary."""
    table = rows[SURROGATES]
    sums = {
        **_trials(table),
        "ttc_critical": table.ttc < TTC_CRITICAL,
        "pet_critical": np.abs(table.pet) < PET_CRITICAL,
        "pet_close": np.abs(table.pet) < PET_CLOSE,
        "drac_critical": table.drac > DRAC_CRITICAL,
        "exposed_time": table.exposed_time,
        "pedestrian_first": table.pet > 0,
    }
    return {name: count_by_type(table.episode, table.type, rows.episodes, values) for name, values in sums.items()}


def summarise_surrogates(rows: Rows, sums: Sums) -> ByType[SurrogateSummary]:
    """Return the surrogates of all encounters, by type."""
    tried = episodes_with(rows, _tried)
    return ByType(*(_summarise_type(rows, kind, sums[SURROGATES], tried) for kind in TYPES))


def _tried(rows: Rows) -> dict[str, np.ndarray]:
    """Return how many encounters are counted below the line of each share, per episode and type."""
    table = rows[SURROGATES]
    return {name: count_by_type(table.episode, table.type, rows.episodes, x) for name, x in _trials(table).items()}


def _trials(table: Surrogates) -> dict[str, np.ndarray]:
    """Return which encounters are counted below the line of each of `SHARES`."""
    return {"met": np.ones(len(table.type)), "one_first": np.abs(table.pet) > 0}


def _summarise_type(
    rows: Rows, kind: int, sums: Mapping[str, np.ndarray], episodes: Mapping[str, np.ndarray]
) -> SurrogateSummary:
    """Return the surrogates of one type; ``episodes`` is the number of those with a trial of each share, by type."""
    own = {name: column[:, kind - 1] for name, column in sums.items()}

    def of_kind(name: str) -> Values:
        return rows.values(lambda chunk: without_nan(getattr(chunk[SURROGATES], name)[chunk[SURROGATES].type == kind]))

    hit = of_kind("impact_speed")

    def share(name: str, over: str) -> Estimate:
        return clustered_share(ratio(own[name], own[over]), own[over][0], episodes[over][kind - 1])

    def spread(values: Values, p: float) -> Spread:
        return Spread(median=quantile(values, 0.5), extreme=quantile(values, p))

    return SurrogateSummary(
        count=int(own["met"][0]),
        ttc=spread(of_kind("ttc"), 0.05),
        pet=spread(of_kind("pet").each(np.abs), 0.05),
        t2=spread(of_kind("t2"), 0.05),
        drac=spread(of_kind("drac"), 0.95),
        exposed_time=interval(ratio(own["exposed_time"], own["met"]), own["met"][0]),
        impact_speed=mean_of(hit, within=(0.0, np.inf)),
        **{name: share(name, over) for name, over in SHARES.items()},
        **{name: mean_of(hit.each(curve), within=(0.0, 1.0)) for name, curve in RISKS.items()},
    )


SURROGATES = Metric(
    name="surrogates",
    measure=lambda recording: measure_surrogates(recording.trajectory, recording[ENCOUNTERS], recording.config),
    needs=(ENCOUNTERS,),
    columns=surrogate_columns,
    summarise=summarise_surrogates,
)
