"""Episodes as an interactive page: one file that needs no network."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.maps import RoadMap
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.writing import write_whole

SCRIPTS = ("record.js", "drawing.js", "strips.js", "touch.js", "player.js")
"""Parts of the player, in the order in which they use each other."""


def document(episodes: Sequence[dict[str, Any]], road_maps: Sequence[RoadMap], *, dt: float) -> dict[str, Any]:
    """What the page's script reads: maps, and `entries` of episodes."""
    return {"dt": dt, "maps": [_map(road_map) for road_map in road_maps], "episodes": list(episodes)}


def entries(trajectory: Trajectory, records: Sequence[str], maps: Sequence[int], **about: Any) -> list[dict[str, Any]]:
    """A page's entries of recorded episodes.

    Args:
        trajectory: the episodes.
        records: of every episode, from `make_records`.
        maps: of every episode, which map of the page it is played on.
        about: what is the same for all: ``driver`` and ``pedestrians`` by name, jaywalk ``multiplier``.
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


def _map(road_map: RoadMap) -> dict[str, Any]:
    def boxes(rectangles: Any) -> list[list[float]]:
        return [box for box in np.asarray(rectangles, float).round(3).tolist() if box[0] < box[2]]

    return {
        "width": float(road_map.width), "height": float(road_map.height), "roads": boxes(road_map.roads),
        "sidewalks": boxes(road_map.sidewalks), "crosswalks": boxes(road_map.crosswalks),
    }  # fmt: skip


def as_script(document: Any) -> str:
    """JSON that may stand inside a page's ``script``: no name in it can end that."""
    return json.dumps(document, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def part(name: str) -> str:
    """A file of the page."""
    return resources.files("jaxwalk.viewer").joinpath("page", name).read_text(encoding="utf-8")


def _joined(*names: str) -> str:
    return "\n".join(part(name) for name in names)


def gallery_html() -> str:
    """The gallery of failures, with a player in a dialog, for another page; it needs the three parts that follow."""
    return part("gallery.html").replace("{{ player }}", part("player.html"))


def gallery_style() -> str:
    """Its style sheet; the page gives the colours ``--ink``, ``--soft``, ``--page``, ``--line`` and ``--tint``."""
    return _joined("player.css", "gallery.css")


def gallery_script() -> str:
    """Its script, a module: the class ``Gallery(element, data)``."""
    return _joined(*SCRIPTS, "gallery.js")


def replay_page(document: dict[str, Any], path: Path, *, title: str) -> None:
    """Write a page on which the episodes of a `document` can be played."""
    import jinja2

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    page = environment.from_string(part("replay.html")).render(
        title=title, css=_joined("page.css", "player.css"), player=part("player.html"), data=as_script(document),
        script=_joined(*SCRIPTS),
    )  # fmt: skip
    write_whole(path, page)
