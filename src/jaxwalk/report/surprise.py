"""The speed differential four ways: what each shows, and what they mean together in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.metrics.speed_differential import SpeedBin, SpeedGap
from jaxwalk.metrics.statistics import Estimate
from jaxwalk.report.table import NONE, shown

COLUMNS = ("distance [m]", "weight", "near crosswalk users [m/s]", "near jaywalkers [m/s]", "difference", "n")
"""Columns of the rows of `four_ways`."""
FEWEST = 20
"""With fewer encounters of either type at a distance, no conclusion is drawn: a bootstrap of few is too confident."""
NOTHING = 0.01
"""A speed difference whose interval comes nearer to 0 than this is not mentioned [m/s]."""


def four_ways(bins: Sequence[SpeedBin]) -> list[tuple[str, ...]]:
    """Return five rows per distance: pooled over frames, by encounter, matched, ghosts, people minus ghosts."""
    rows = []
    for found in bins:
        at, placebo = place(found), found.placebo
        gaps = {"frames": found.pooled, "encounters": found.by_encounter}
        rows += [(at, name, *_gap(gap, name)) for name, gap in gaps.items()]
        rows.append((at, "matched", NONE, NONE, *_alone(found.matched, "jaywalkers' encounters")))
        rows.append((at, "ghosts", *_gap(placebo.ghosts, "frames")))
        rows.append((at, "people minus ghosts", NONE, NONE, *_alone(placebo.difference, "frames or more")))
    return rows


def place(found: SpeedBin) -> str:
    """Return a bin's distances as in ``0 to 3``."""
    return f"{found.near:g} to {found.far:g}"


def _gap(gap: SpeedGap, unit: str) -> tuple[str, ...]:
    counts = f"{gap.crosswalk.count:,} and {gap.jaywalk.count:,} {unit}"
    return *(shown(x, 1.0, 2) for x in (gap.crosswalk, gap.jaywalk, gap.difference)), counts


def _alone(number: Estimate, unit: str) -> tuple[str, str]:
    return shown(number, 1.0, 2), f"{number.count:,} {unit}"


def in_words(bins: Sequence[SpeedBin]) -> str:
    """Return what the four mean together: is the car faster near jaywalkers, and more so than near ghosts?

    Each 95 % interval is taken separately: among twenty without a true difference, about one shows one.
    """
    bins = [found for found in bins if found.by_encounter.difference.count >= FEWEST]
    if not bins:
        return "Too few people were near the car to say."
    raw = _said(bins, lambda found: found.pooled.difference)
    beyond = _said(bins, lambda found: found.placebo.difference)
    matched = _said(bins, lambda found: found.matched)
    nowhere = (
        f"At no distance with {FEWEST} encounters or more of either type is the interval of the difference between "
        "jaywalkers and crosswalk users free of 0."
    )
    sentences = [f"Near jaywalkers the car is {raw}." if raw else nowhere]
    if beyond:
        sentences.append(f"Beyond the difference near ghosts, which it cannot see, it is {beyond}.")
    elif raw:
        sentences.append("No interval shows more than near ghosts, which it cannot see: the place may explain it.")
    else:
        sentences.append("Nor is there more than near ghosts, which it cannot see.")
    same = "At nearly the same place and initial speed"
    sentences.append(f"{same} it is {matched}." if matched else f"{same} no interval shows a difference.")
    return " ".join(sentences)


def _said(bins: Sequence[SpeedBin], find: Callable[[SpeedBin], Number]) -> str:
    """Return words such as ``faster at 0 to 3 m``, for intervals entirely above or below 0; empty if there are none."""
    sides = _sides(bins, find)
    return " and ".join(f"{side} at {', '.join(places)} m" for side, places in sides.items() if places)


def _sides(bins: Sequence[SpeedBin], find: Callable[[SpeedBin], Number]) -> dict[str, list[str]]:
    """Return the distances at which a difference is certainly above 0 (faster), and certainly below (slower)."""
    sides: dict[str, list[str]] = {"faster": [], "slower": []}
    for found in bins:
        number = find(found)
        if number.low is not None and number.low > NOTHING:
            sides["faster"].append(place(found))
        if number.high is not None and number.high < -NOTHING:
            sides["slower"].append(place(found))
    return sides
