"""``jaxwalk map draw``."""

from __future__ import annotations

from pathlib import Path

from jaxwalk.cli.checks import check_no_folder
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.map_check import describe
from jaxwalk.cli.options import MapDraw
from jaxwalk.maps import load_network, map_name
from jaxwalk.runs.folder import check_writable
from jaxwalk.viewer.street_picture import street_picture

PICTURES = (".png", ".svg", ".pdf")
"""Endings of pictures."""


def run(options: MapDraw) -> int:
    """Draw the map."""
    name = map_name(options.map)
    out = options.out or Path(f"{name.removesuffix('.toml').removesuffix('.json')}.png")
    check(out)
    network = load_network(options.map)
    out.parent.mkdir(parents=True, exist_ok=True)
    street_picture(network, out, name)
    print(f"{out}: {describe(network)}")
    return 0


def check(out: Path) -> None:
    """Raise an error for a file that can't be written."""
    if out.suffix.lower() not in PICTURES:
        raise UsageError(f"--out {out}: the name must end in one of {', '.join(PICTURES)}")
    check_no_folder(out)
    check_writable(out.parent)
