"""The page of crash tests: a matrix of tests and speeds for each driver, and a replay behind each cell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from jaxwalk.evaluation.crash_outcomes import CrashOutcome
from jaxwalk.evaluation.crash_results import NOTICE, CrashResults, DriverUnderTest
from jaxwalk.viewer.filled_page import filled_in
from jaxwalk.viewer.replay import as_script, gallery_style, player_html, player_script
from jaxwalk.writing import write_whole

WORST = 60.0
"""An impact at this speed or above has the darkest colour [km/h]."""


@dataclass(frozen=True)
class CrashCell:
    """One run in a matrix."""

    kind: str
    """Its result, as a name of a style."""
    text: str
    """What is written there."""
    about: str
    """The same in a sentence."""
    share: float
    """How dark it is, from 0 to 1."""
    episode: int
    """Its place among the page's episodes."""
    beyond: bool
    """Whether the car is faster than in the driver's training."""


def matrix(driver: DriverUnderTest, speeds: Sequence[float], first: int) -> list[tuple[str, list[CrashCell | None]]]:
    """Return a row for each test: its name, and a cell for each speed; None where it isn't played.

    ``first`` is the place of the driver's first episode among the page's.
    """
    rows: dict[str, dict[float, CrashCell]] = {}
    for place, outcome in enumerate(driver.outcomes):
        name = outcome.test if outcome.variant is None else f"{outcome.test}, {outcome.variant}"
        rows.setdefault(name, {})[outcome.speed] = _cell(outcome, driver, first + place)
    return [(name, [cells.get(speed) for speed in speeds]) for name, cells in rows.items()]


def _cell(outcome: CrashOutcome, driver: DriverUnderTest, episode: int) -> CrashCell:
    beyond = driver.trained_to is not None and outcome.speed > driver.trained_to + 0.05
    short = {"avoided": "avoids", "not met": "not met", "kept": "keeps", "braked": "brakes"}
    text = short.get(outcome.result, "") if outcome.impact is None else f"{outcome.impact:.0f}"
    asked = {None: "", True: "; passes", False: "; fails"}[outcome.passed]
    return CrashCell(
        kind=outcome.result.replace(" ", "-") if outcome.impact is None or not outcome.no_brake else "unslowed",
        text=text + (" ↔" if outcome.swerves else "") + {None: "", True: " ✓", False: " ✗"}[outcome.passed],
        about=f"{driver.name}, {outcome.test} at {outcome.speed:g} km/h: {in_words(outcome)}{asked}",
        share=min((outcome.impact or 0.0) / WORST, 1.0),
        episode=episode,
        beyond=beyond,
    )


def in_words(outcome: CrashOutcome) -> str:
    """Return what a driver did in words."""
    aside = f"; {outcome.aside:.1f} m beside its route" if outcome.swerves else ""
    if outcome.impact is not None:
        where = "" if outcome.hit_point is None else f", {outcome.hit_point:.0f} % of the front"
        how = "hit" if outcome.result == "slowed" else "hit without having slowed down"
        return f"{how}, at {outcome.impact:.1f} km/h{where}{aside}"
    if outcome.no_brake:
        how = f"hardest braking {outcome.hardest:.1f} m/s², lowest speed {outcome.slowest:.0f} km/h"
        return f"{'keeps its speed' if outcome.result == 'kept' else 'brakes without need'}: {how}{aside}"
    later = "; touches them later, when the test is over" if outcome.touched_later else ""
    what = "avoids the contact" if outcome.result == "avoided" else "never comes near, so nobody sets out"
    return f"{what}{later}{aside}"


def write_crash_page(path: Path, results: CrashResults, document: dict[str, Any]) -> None:
    """Write the page. ``document`` has the episodes of all drivers, in the order of their outcomes."""
    speeds = sorted({outcome.speed for driver in results.drivers for outcome in driver.outcomes})
    firsts = [sum(len(driver.outcomes) for driver in results.drivers[:n]) for n in range(len(results.drivers))]
    tables = [(driver, matrix(driver, speeds, first)) for driver, first in zip(results.drivers, firsts, strict=True)]
    template = resources.files("jaxwalk.report").joinpath("crash_page.html").read_text(encoding="utf-8")
    page = filled_in(
        template,
        results=results, speeds=speeds, tables=tables, notice=NOTICE, css=gallery_style(), player=player_html(),
        script=player_script(), data=as_script(document),
    )  # fmt: skip
    write_whole(path, page)
