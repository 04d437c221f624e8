"""The suite's numbers of anybody's trajectories, and what could not be told from them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from typing import Any

from jaxwalk.formats.areas import Areas
from jaxwalk.formats.recordings import GAP, measure_tracks
from jaxwalk.formats.tracks import Tracks, TracksError
from jaxwalk.metrics import OUTCOMES, Rows, summarise
from jaxwalk.sim.config import SimConfig

ANYBODY = "anybody"
"""The one type of encounter where it is not known where the roadway is."""
WAITING = ("at_kerb", "enters_roadway", "going", "predicted_miss")
"""Columns that the metrics of waiting need."""
CHOICES = ("crossing", "decisions", "jaywalking_tendency")
"""Columns that the jaywalk rate needs."""
CONTACT_NAMES = ("crosswalk", "jaywalk", "sidewalk")
"""What people who were hit were doing."""
OF_HITS = ("impact_speed", "mais3", "fatal", "fatal_rosen_sander")
"""Numbers of those who were hit."""


@dataclass(frozen=True)
class Measured:
    """What trajectories say."""

    rows: Rows
    known: frozenset[str]
    """Optional columns that all of them had."""
    ground: bool
    """Whether it is known where the roadway and the crosswalks are."""

    def as_dict(self) -> dict[str, Any]:
        """The metrics of `jaxwalk.metrics.Summary` that these trajectories can tell, and why others are left out."""
        found, left_out = summarise(self.rows).as_dict(), {}
        for name, columns in (("jaywalk_rate", CHOICES), ("waiting", WAITING)):
            if missing := [column for column in columns if column not in self.known]:
                left_out[name] = f"the table has no column {', '.join(missing)}"
                del found[name]
        outcomes = found["outcomes"]
        if not {"ending", "touched"} <= self.known:
            left_out["outcomes, attribution, those who were hit"] = "the table has no column ending, touched"
            del found["outcomes"], found["attribution"]
            for kind in found["encounters"]:
                del found["encounters"][kind]["collided"]
                found["surrogates"][kind] = _without(found["surrogates"][kind], OF_HITS)
        if not self.ground:
            left_out["speed_differential, crosswalk and jaywalk, braking"] = "no areas say where roadway is"
            found = _of_anybody(found)
        steps = self.rows[OUTCOMES].steps.sum() * self.rows.dt
        return {
            "episodes": found.pop("episodes"),
            "kilometres": outcomes["kilometres"],
            "hours": float(steps / 3600),
            **found,
            "left_out": left_out,
        }


def measure_all(
    recordings: Iterable[tuple[Tracks, Areas | None]],
    *,
    config: SimConfig,
    progress: Callable[[int], None] | None = None,
) -> Measured:
    """Measure recordings, one after the other.

    Args:
        recordings: at least one with a car that moves; each with its areas, which a table that says who is on a
            roadway doesn't need.
        config: of its values, the step of the resampling, when a car is moving and what is a touch are used.
        progress: called after each recording with their number so far.

    Raises:
        TracksError: no car moves, or a recording can't be.
    """
    parts, known, ground = [], None, True
    for number, (tracks, areas) in enumerate(recordings, start=1):
        ground &= areas is not None or {"on_roadway", "on_crosswalk"} <= tracks.known.keys()
        known = frozenset(tracks.known).intersection(tracks.known if known is None else known)
        parts += measure_tracks(tracks, areas=areas, config=config)
        if progress is not None:
            progress(number)
    if known is None or not parts:
        raise TracksError(
            f"there is no car that moves for two frames (rows more than {GAP:g} s apart are cut): nothing to measure"
        )
    return Measured(Rows.join(parts), known, ground)


def _of_anybody(found: dict[str, Any]) -> dict[str, Any]:
    """Without what needs to know where the roadway is."""
    encounters = _without(found["encounters"]["jaywalk"], ("braking",))  # on no crosswalk, as far as is known
    of_anybody = {name: {ANYBODY: found[name]["jaywalk"]} for name in ("surrogates", "surrogate_distributions")}
    rest = _without(found, ("speed_differential", "attribution", "jaywalk_rate", "waiting"))
    if "outcomes" in rest:
        rest["outcomes"] = _without(rest["outcomes"], CONTACT_NAMES)
    return {**rest, **of_anybody, "encounters": {ANYBODY: encounters}}


def _without(found: dict[str, Any], names: Collection[str]) -> dict[str, Any]:
    return {name: value for name, value in found.items() if name not in names}
