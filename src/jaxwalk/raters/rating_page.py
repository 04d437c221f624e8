"""The page that raters open: two clips of one scenario beside each other, and a file of answers to save at the end."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from jaxwalk.raters.rating_plan import LENGTH, REPEATED, SCHEMA, RatingPlan
from jaxwalk.viewer.filled_page import filled_in
from jaxwalk.viewer.replay import as_script, part
from jaxwalk.writing import write_whole

SCRIPTS = ("record.js", "drawing.js")
"""The player's scripts that draw a clip."""
HIDDEN = ("driver", "pedestrians", "scenario", "multiplier", "ending")
"""What a page's entries know and raters must not."""
SECONDS_EACH = 15
"""What a rater takes for a pair [s]."""


def write_rating_page(path: Path, plan: RatingPlan, document: dict[str, Any]) -> None:
    """Write the page. ``document`` has an entry for each clip of the plan (`clips_of`), in any order."""
    shown = plan.each + REPEATED + sum(pair.safer is not None for pair in plan.pairs)
    page = filled_in(
        _part("rating.html"),
        question=plan.question,
        count=shown,
        minutes=max(1, round(shown * SECONDS_EACH / 60)),
        css="\n".join([part("page.css"), part("player.css"), _part("rating.css")]),
        script="\n".join([*(part(name) for name in SCRIPTS), _part("rating.js")]),
        data=as_script(page_data(plan, document)),
    )
    write_whole(path, page)


def page_data(plan: RatingPlan, document: dict[str, Any]) -> dict[str, Any]:
    """Return what the page's script reads: clips without names, and pairs of their places."""
    needed = clips_of(plan)
    entries = {(entry["driver"], entry["scenario"]): entry for entry in document["episodes"]}
    clips = [{name: x for name, x in entries[clip].items() if name not in HIDDEN} for clip in needed]
    places = {clip: place for place, clip in enumerate(needed)}
    pairs = [
        {
            "a": places[plan.players[pair.a], pair.scenario],
            "b": places[plan.players[pair.b], pair.scenario],
            "start": pair.start,
            "check": pair.safer is not None,
        }
        for pair in plan.pairs
    ]
    return {
        "schema": SCHEMA, "plan": plan.id, "dt": document["dt"], "maps": document["maps"], "clips": clips,
        "pairs": pairs, "each": plan.each, "repeated": REPEATED, "length": LENGTH,
    }  # fmt: skip


def clips_of(plan: RatingPlan) -> Sequence[tuple[str, int]]:
    """Return the driver and the scenario of every clip that a plan's pairs need, each once."""
    sides = ((plan.players[side], pair.scenario) for pair in plan.pairs for side in (pair.a, pair.b))
    return list(dict.fromkeys(sides))


def _part(name: str) -> str:
    return resources.files("jaxwalk.raters").joinpath(name).read_text(encoding="utf-8")
