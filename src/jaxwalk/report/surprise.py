"""The speed differential four ways: what each says, and in words what they say together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from jaxwalk.report.table import NONE, shown

COLUMNS = ("distance [m]", "weight", "near crosswalk users [m/s]", "near jaywalkers [m/s]", "difference", "n")
"""Of the rows of `four_ways`."""
NOTHING = 0.01
"""A speed difference whose interval comes nearer to 0 than this is not worth a word [m/s]."""


def four_ways(bins: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Five rows for each distance: pooled over frames, by encounter, matched, near ghosts, and people minus ghosts."""
    rows = []
    for found in bins:
        place, placebo = f"{found['near']:g} to {found['far']:g}", found["placebo"]
        gaps = {"frames": found["pooled"], "encounters": found["by_encounter"]}
        rows += [(place, name, *_gap(gap, name)) for name, gap in gaps.items()]
        rows.append((place, "matched", NONE, NONE, *_alone(found["matched"], "jaywalkers' encounters")))
        rows.append((place, "ghosts", *_gap(placebo["ghosts"], "frames")))
        rows.append((place, "people minus ghosts", NONE, NONE, *_alone(placebo["difference"], "frames or more")))
    return rows


def _gap(gap: Mapping[str, Any], unit: str) -> tuple[str, ...]:
    counts = f"{gap['crosswalk']['count']:,} and {gap['jaywalk']['count']:,} {unit}"
    return *(shown(gap[kind], 1.0, 2) for kind in ("crosswalk", "jaywalk", "difference")), counts


def _alone(number: Mapping[str, Any], unit: str) -> tuple[str, str]:
    return shown(number, 1.0, 2), f"{number['count']:,} {unit}"


def in_words(bins: Sequence[Mapping[str, Any]]) -> str:
    """What the four say together: is the car faster near jaywalkers, and is that surprise or the place?"""
    raw = _sides(bins, lambda found: found["pooled"]["difference"])
    beyond = _sides(bins, lambda found: found["placebo"]["difference"])
    matched = _sides(bins, lambda found: found["matched"])
    if not any(raw.values()):
        first = "No distance shows another speed near jaywalkers than near crosswalk users"
    else:
        first = "; ".join(f"the car is {side} near jaywalkers at {_list(at)} m" for side, at in raw.items() if at)
    if not any(beyond.values()):
        second = "but beyond what is so near ghosts, whom it cannot see, no difference is left: the place explains it"
        if not any(raw.values()):
            second = "and nothing beyond what is so near ghosts, whom it cannot see"
    else:
        second = "; ".join(
            f"beyond what is so near ghosts, whom it cannot see, it is {side} at {_list(at)} m"
            for side, at in beyond.items()
            if at
        )
    third = "; ".join(f"it is {side} at {_list(at)} m" for side, at in matched.items() if at)
    third = f"Matched on place and initial speed, {third or 'no difference is left'}."
    sentences = f"{first}, {second}. {third}"
    return sentences[0].upper() + sentences[1:] + " (95 % intervals, each for itself.)"


def _sides(bins: Sequence[Mapping[str, Any]], find: Any) -> dict[str, list[str]]:
    """Distances at which a difference is certainly above 0 (faster), and certainly below (slower)."""
    sides: dict[str, list[str]] = {"faster": [], "slower": []}
    for found in bins:
        number, place = find(found), f"{found['near']:g} to {found['far']:g}"
        if number["low"] is not None and number["low"] > NOTHING:
            sides["faster"].append(place)
        if number["high"] is not None and number["high"] < -NOTHING:
            sides["slower"].append(place)
    return sides


def _list(places: Sequence[str]) -> str:
    return " and ".join(places) if len(places) < 3 else f"{', '.join(places[:-1])} and {places[-1]}"
