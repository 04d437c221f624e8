"""Metrics of trajectories from any source, and the reasons why some metrics are left out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from typing import Any

from jaxwalk.formats.areas import Areas
from jaxwalk.formats.recordings import GAP, measure_tracks
from jaxwalk.formats.tracks import Tracks, TracksError
from jaxwalk.metrics import OUTCOMES, Rows, summarise
from jaxwalk.sim.crossing_kind import CONTACTS
from jaxwalk.sim.sim_config import SimConfig

ANYBODY = "anybody"
"""The only kind of encounter if the roadway is unknown."""
WAITING = ("at_kerb", "enters_roadway", "going", "predicted_miss")
"""Columns that the metrics of waiting need."""
CHOICES = ("crossing", "decisions", "jaywalking_tendency")
"""Columns that the jaywalk rate needs."""
CONTACT_NAMES = tuple(kind.word for kind in CONTACTS)
"""Where pedestrians who were hit were walking."""
OF_HITS = ("impact_speed", "mais3", "fatal", "fatal_rosen_sander")
"""Metrics of pedestrians who were hit."""


@dataclass(frozen=True)
class Measured:
    """Measured trajectories."""

    rows: Rows
    known: frozenset[str]
    """Optional columns that all recordings have."""
    ground: bool
    """Whether the roadway and the crosswalks are known."""

    def as_dict(self) -> dict[str, Any]:
        """Return the metrics of `jaxwalk.metrics.Summary` that can be computed, and why others are left out."""
        found, left_out = _without(summarise(self.rows).as_dict(), ["delay", "shield"]), {}  # no file has these
        needs = {"jaywalk_rate": CHOICES, **dict.fromkeys(("waiting", "approaches", "gaps"), WAITING)}
        for name, columns in needs.items():
            if missing := [column for column in columns if column not in self.known]:
                left_out[name] = f"the table has no column {', '.join(missing)}"
                del found[name]
        outcomes = found["outcomes"]
        if not {"ending", "touched"} <= self.known:
            name = "outcomes, attribution, passing, impact_tail, yielded, those who were hit"
            left_out[name] = "the table has no column ending, touched"
            del found["outcomes"], found["attribution"], found["passing"], found["impact_tail"]
            found.get("approaches", {}).pop("yielded", None)
            for kind in found["encounters"]:
                del found["encounters"][kind]["collided"]
                found["surrogates"][kind] = _without(found["surrogates"][kind], OF_HITS)
        if not self.ground:
            left_out["speed_differential, approaches, crosswalk and jaywalk, braking"] = "no areas say where roadway is"
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
        recordings: recordings, each with its areas; at least one has a car that moves. A table that states who is on a
            roadway needs no areas.
        config: gives the step of the resampling, the speed of a moving car, the size of a body, and that of a car
            whose track doesn't state it.
        progress: called after each recording with the number of recordings so far.

    Raises:
        TracksError: no car moves, or a recording is invalid.
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
            f"no car moves for two frames (a gap of more than {GAP:g} s cuts a track): nothing to measure"
        )
    return Measured(Rows.join(parts), known, ground)


def _of_anybody(found: dict[str, Any]) -> dict[str, Any]:
    """Return the metrics without those that need a known roadway."""
    encounters = _without(found["encounters"]["jaywalk"], ("braking",))  # without areas, nobody is on a crosswalk
    of_anybody = {name: {ANYBODY: found[name]["jaywalk"]} for name in ("surrogates", "surrogate_distributions")}
    rest = _without(found, ("speed_differential", "attribution", "jaywalk_rate", "waiting", "approaches"))
    rest["contacts"] = {rule: _without(one, CONTACT_NAMES) for rule, one in rest["contacts"].items()}
    if "outcomes" in rest:
        rest["outcomes"] = _without(rest["outcomes"], CONTACT_NAMES)
    return {**rest, **of_anybody, "encounters": {ANYBODY: encounters}}


def _without(found: dict[str, Any], names: Collection[str]) -> dict[str, Any]:
    return {name: value for name, value in found.items() if name not in names}
