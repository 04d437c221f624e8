"""Episodes as an interactive page: one file that works without a network."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.maps.network import Network
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.viewer.drawn_map import DrawnMap
from jaxwalk.viewer.filled_page import filled_in
from jaxwalk.writing import write_whole

SCRIPTS = ("record.js", "drawing.js", "strips.js", "touch.js", "player.js")
"""Scripts of the player; each one uses only those before it."""


def document(episodes: Sequence[dict[str, Any]], networks: Sequence[Network], *, dt: float) -> dict[str, Any]:
    """Return the data of a page: maps, and `entries` of episodes. ``dt`` is the length of a step [s]."""
    return {"dt": dt, "maps": [asdict(DrawnMap.of(network)) for network in networks], "episodes": list(episodes)}


def entries(trajectory: Trajectory, records: Sequence[str], maps: Sequence[int], **about: Any) -> list[dict[str, Any]]:
    """Return a page's entries of recorded episodes.

    Args:
        trajectory: the episodes.
        records: each episode's record, from `make_records`.
        maps: each episode's map, as an index into the page's maps.
        about: fields that are the same for all: ``driver`` and ``pedestrians`` by name, jaywalk ``multiplier``.
    """
    t = trajectory
    endings = np.where(t.goal, "goal", np.where(t.collision, "collision", "timeout"))
    return [
        {
            **about, "scenario": int(t.scenario[i]), "ending": str(endings[i]), "steps": int(t.length[i]),
            "map": int(maps[i]), "record": records[i],
        }
        for i in range(len(t.length))
    ]  # fmt: skip


def as_script(document: Any) -> str:
    """Return JSON that is safe inside a page's ``script`` element: no text in it can end the element."""
    return json.dumps(document, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def part(name: str) -> str:
    """Return the text of one of the page's files."""
    return resources.files("jaxwalk.viewer").joinpath("page", name).read_text(encoding="utf-8")


def _joined(*names: str) -> str:
    return "\n".join(part(name) for name in names)


def player_html() -> str:
    """Return the player. Its page also needs the style of the gallery, and `player_script`."""
    return part("player.html")


def player_script() -> str:
    """Return the player's script, a module with the class ``Player(element, data)``."""
    return _joined(*SCRIPTS)


def gallery_html() -> str:
    """Return the gallery of failures, with a player in a dialog. Its page also needs the style and the script."""
    return part("gallery.html").replace("{{ player }}", part("player.html"))


def gallery_style() -> str:
    """Return the gallery's style sheet. Its page sets ``--ink``, ``--soft``, ``--page``, ``--line``, ``--tint``."""
    return _joined("player.css", "gallery.css")


def gallery_script() -> str:
    """Return the gallery's script, a module with the class ``Gallery(element, data)``."""
    return _joined(*SCRIPTS, "gallery.js")


def replay_page(document: dict[str, Any], path: Path, *, title: str) -> None:
    """Write a page that plays the episodes of a `document`."""
    page = filled_in(
        part("replay.html"), title=title, css=_joined("page.css", "player.css"), player=part("player.html"),
        data=as_script(document), script=_joined(*SCRIPTS),
    )  # fmt: skip
    write_whole(path, page)
