"""The page of `jaxwalk live`: the drawings of the player, and controls of its own."""

from __future__ import annotations

from importlib import resources

from jaxwalk.viewer.filled_page import filled_in
from jaxwalk.viewer.replay import part, player_script

SCRIPTS = ("growing.js", "wheel.js", "live.js")
"""Scripts beside those of the player; each one uses only those before it."""


def live_page(once: str) -> str:
    """Return the page. ``once`` is the mark by which the browser knows that its script is the server's."""
    css = "\n".join((part("page.css"), part("player.css"), _own("live.css")))
    script = "\n".join((player_script(), *map(_own, SCRIPTS)))
    return filled_in(_own("live.html"), css=css, script=script, once=once)


def _own(name: str) -> str:
    return resources.files("jaxwalk.live").joinpath(name).read_text(encoding="utf-8")
