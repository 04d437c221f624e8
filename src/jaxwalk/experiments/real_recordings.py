"""Real recordings and ours, measured alike: cars near crosswalk users and others, and what people do in a car's path.

Everything is read from positions through a window of the same size, so that ours can be no better known than the real
one (``docs/real-recordings.md``). Intervals are bootstraps over recordings: clips of a camera, or episodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy
import shapely
from jaxtyping import Bool, Float, Int

from jaxwalk.formats.areas import Areas
from jaxwalk.formats.clip_grounds import ClipGrounds
from jaxwalk.formats.recordings import measure_tracks
from jaxwalk.formats.tracks import PEDESTRIAN, Tracks, TracksError, tracks_of
from jaxwalk.formats.vci import PEOPLE, read_vci
from jaxwalk.metrics import ENCOUNTERS, SPEED_DIFFERENTIAL, SURROGATES, Rows
from jaxwalk.metrics.crossings import TYPES
from jaxwalk.metrics.meetings import BIN_WIDTH, BINS
from jaxwalk.metrics.path_meetings import PATH_MEETINGS, measures
from jaxwalk.metrics.statistics import Estimate, episode_draws, episode_sums, interval, ratio
from jaxwalk.metrics.surrogate import surrogate_columns
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory

WINDOW = 10.0
"""Half the side of the window about a crosswalk in which we look at our own episodes [m]: a drone saw about as much."""
MEASURED = (SPEED_DIFFERENTIAL, ENCOUNTERS, SURROGATES, PATH_MEETINGS)
WHERE = {CROSSWALK: "crosswalk", JAYWALK: "elsewhere"}
"""People by the place where they stepped onto the roadway."""
SURROGATE_SHARES = ("ttc_critical", "pet_critical", "drac_critical")


@dataclass(frozen=True)
class Watched:
    """Measured recordings."""

    rows: Rows
    recording: Int[np.ndarray, "episode"]
    """The recording of each car's time in view, 0, 1, ..."""
    recordings: int

    @property
    def of_meeting(self) -> Int[np.ndarray, "meeting"]:
        """The recording of each meeting of a way and a path."""
        return self.recording[self.rows[PATH_MEETINGS].episode]


def halves(grounds: ClipGrounds) -> tuple[list[str], list[str]]:
    """Return the clips to fit something to, every second one from the first, and all others, to test it on."""
    names = sorted(grounds.clips)
    return names[::2], names[1::2]


def watch_clips(folder: Path, grounds: ClipGrounds, names: Sequence[str]) -> Watched:
    """Measure clips of a folder. Raises TracksError if one isn't there or can't be read, or no car moves in any."""

    def parts(name: str) -> Iterator[Rows]:
        tracks = read_vci(folder / f"{name}{PEOPLE}", frame_rate=grounds.frame_rate)
        return measure_tracks(tracks, areas=grounds.areas(name), config=SimConfig(), metrics=MEASURED)

    return _watched([list(parts(name)) for name in names])


def watch_episodes(trajectory: Trajectory, areas: Areas, config: SimConfig) -> Watched:
    """Measure episodes of ours as a camera over each crosswalk sees them, which knows nothing but positions."""

    def parts(tracks: Tracks) -> Iterator[Rows]:
        for seen in in_windows(tracks, areas):
            yield from measure_tracks(seen, areas=areas, config=config, metrics=MEASURED)

    return _watched([list(parts(tracks)) for tracks in tracks_of(trajectory)])


def in_windows(tracks: Tracks, areas: Areas) -> Iterator[Tracks]:
    """Yield what is seen through the window about each crosswalk, without what only a simulator knows.

    Windows of neighbours overlap. A car is seen through all of them; a person who goes onto the roadway only through
    that of the crosswalk that is nearest to the way there, so that nobody counts twice. Raises TracksError if there is
    no crosswalk.
    """
    places = shapely.get_coordinates(shapely.centroid(shapely.get_parts(areas.crosswalk)))
    if not len(places):
        raise TracksError("this street has no crosswalk to look at; choose one that has")
    aside = np.abs(np.stack([tracks.x, tracks.y], axis=1)[:, None] - places).max(axis=2)
    people = tracks.type == PEDESTRIAN
    nearest = _nearest(tracks, people & areas.locate(tracks.x, tracks.y)[0], aside)
    columns = {field.name: getattr(tracks, field.name) for field in fields(Tracks)}
    for number in range(len(places)):
        seen = (aside[:, number] <= WINDOW) & (~people | (nearest == number))
        kept = {name: values[seen] for name, values in columns.items() if isinstance(values, np.ndarray)}
        yield replace(tracks, known={}, **kept)


def _nearest(
    tracks: Tracks, crossing: Bool[np.ndarray, "row"], aside: Float[np.ndarray, "row place"]
) -> Int[np.ndarray, "row"]:
    """Return the number of the crosswalk at which each row counts: the nearest one to a whole stay on the roadway.

    Rows before a stay belong to it, as the way there. ``aside`` is the distance as a window measures it [m].
    """
    order = np.lexsort((tracks.t, tracks.id))
    on, who = crossing[order], tracks.id[order]
    begins = np.append(True, (np.diff(who) != 0) | (on[:-1] & ~on[1:]))
    stay = np.cumsum(begins) - 1
    # A place on the way counts only if the person never is on the roadway: it is farther off than any place there.
    away = aside[order] + np.where(on, 0.0, aside.max())[:, None]
    nearest = np.empty(len(order), int)
    nearest[order] = np.minimum.reduceat(away, np.flatnonzero(begins)).argmin(axis=1)[stay]
    return nearest


def _watched(parts: list[list[Rows]]) -> Watched:
    rows = [row for part in parts for row in part]
    if not rows:
        raise TracksError("no car moves in these recordings: nothing to measure")
    return Watched(Rows.join(rows), np.repeat(np.arange(len(parts)), [len(part) for part in parts]), len(parts))


def describe(watched: Watched) -> dict[str, Any]:
    """Return the numbers of recordings with 95 % intervals over recordings, ready for JSON."""
    return {
        "recordings": watched.recordings,
        "cars": watched.rows.episodes,
        "speeds": list(_speeds(watched)),
        "encounters": _encounters(watched),
        "meetings": _meetings(watched),
    }


def _sums(watched: Watched, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return columns that have a row per episode, summed over all recordings and over drawn ones."""
    whole = {}
    for name, values in columns.items():
        whole[name] = np.zeros((watched.recordings, *np.shape(values)[1:]))
        np.add.at(whole[name], watched.recording, values)
    return episode_sums(whole)


def _speeds(watched: Watched) -> Iterator[dict[str, Any]]:
    """Yield mean speeds of cars in encounters by distance, each encounter weighing the same [m/s]."""
    sums = _sums(watched, dict(SPEED_DIFFERENTIAL.columns(watched.rows)))
    mean, count = ratio(sums["meeting_speed"], sums["meetings"]), sums["meetings"][0]
    for i in range(BINS):
        crosswalk, elsewhere = (mean[:, kind - 1, i] for kind in (CROSSWALK, JAYWALK))
        yield {
            "near": i * BIN_WIDTH,
            "far": (i + 1) * BIN_WIDTH,
            "crosswalk": asdict(interval(crosswalk, count[CROSSWALK - 1, i])),
            "elsewhere": asdict(interval(elsewhere, count[JAYWALK - 1, i])),
            "difference": asdict(interval(elsewhere - crosswalk, count[:, i].min())),
        }


def _encounters(watched: Watched) -> dict[str, Any]:
    """Return shares of critical encounters, by where people stepped onto the roadway."""
    sums = _sums(watched, surrogate_columns(watched.rows))
    met = sums["met"]
    return {
        WHERE[kind]: {
            name: asdict(interval(ratio(sums[name][:, kind - 1], met[:, kind - 1]), met[0, kind - 1]))
            for name in SURROGATE_SHARES
        }
        for kind in TYPES
    }


def _meetings(watched: Watched) -> dict[str, Any]:
    """Return the numbers of meetings of a way and a path: shares, and medians of the rest."""
    table, found = watched.rows[PATH_MEETINGS], measures(watched.rows[PATH_MEETINGS])
    shares = {"waited": found.pop("waited"), "pedestrian_first": (table.pet > 0).astype(float)}
    numbers = {name: over_recordings(watched, values, np.mean) for name, values in shares.items()}
    numbers |= {name: over_recordings(watched, values, np.median) for name, values in found.items()}
    return {name: asdict(number) for name, number in numbers.items()}


def over_recordings(
    watched: Watched, values: Float[np.ndarray, "meeting"], statistic: Callable[[np.ndarray], Any]
) -> Estimate:
    """Return a statistic of the meetings that have a value, with its interval over recordings."""
    there = ~np.isnan(values)
    known, recording = values[there], watched.of_meeting[there]
    return interval(_drawn(known, recording, watched.recordings, statistic), len(known))


def _drawn(
    values: np.ndarray, recording: np.ndarray, recordings: int, statistic: Callable[[np.ndarray], Any]
) -> Float[np.ndarray, "draw"]:
    """Return a statistic of all values, then of those of drawn recordings; NaN where there are none."""
    _, times = next(iter(episode_draws(recordings)))
    samples = (np.repeat(values, np.nan_to_num(row).astype(int)[recording]) for row in times)
    return np.array([statistic(sample) if len(sample) else np.nan for sample in samples])


def distances(real: Watched, ours: dict[str, Watched]) -> dict[str, dict[str, Float[np.ndarray, "draw"]]]:
    """Return how far populations are from real meetings in each measure: Wasserstein-1, in the measure's unit.

    The first number is over all real recordings, the others over drawn ones, the same ones for all populations.
    """
    found: dict[str, dict[str, np.ndarray]] = {}
    for name, values in measures(real.rows[PATH_MEETINGS]).items():
        there = ~np.isnan(values)
        of_ours = {who: measures(watched.rows[PATH_MEETINGS])[name] for who, watched in ours.items()}
        found[name] = {
            who: _drawn(values[there], real.of_meeting[there], real.recordings, _away_from(sample))
            for who, sample in of_ours.items()
        }
    return found


def _away_from(sample: np.ndarray) -> Callable[[np.ndarray], float]:
    """Return a function that says how far values are from a sample; NaN for a sample of nothing."""
    known = sample[~np.isnan(sample)]
    return lambda values: float(scipy.stats.wasserstein_distance(known, values)) if len(known) else np.nan
