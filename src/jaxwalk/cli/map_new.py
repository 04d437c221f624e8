"""``jaxwalk map new``."""

from __future__ import annotations

from math import isfinite

from jaxwalk.cli.errors import UsageError, bad_values
from jaxwalk.cli.options import MapNew
from jaxwalk.maps import checked, map_content
from jaxwalk.maps.template import street_map
from jaxwalk.runs.folder import check_writable
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.wording import counted
from jaxwalk.writing import write_whole

USUAL = {"length": 100.0, "width": 8.0}
"""Length of a street, and width of its roadway [m]."""
LIMITS = {"length": (40.0, 1000.0), "width": (5.0, 14.0)}
"""Least and largest value of options [m]."""


def run(options: MapNew) -> int:
    """Write the file."""
    check(options)
    with bad_values():
        text = map_content(options.like) if options.like else _street(options)
    kind = ".json" if text.startswith("{") else ".toml"
    if options.file.suffix != kind:
        raise UsageError(f"{options.file}: the name must end in {kind}")
    usual = SimConfig()
    checked(text, str(options.file), goal_spacing=usual.goal_spacing, start_clearance=usual.start_clearance)
    options.file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(options.file, text)
    about = f"a copy of {options.like}" if options.like else f"a street with {counted(_places(options), 'crosswalk')}"
    print(f"{options.file}: {about}; edit it, then: jaxwalk map check {options.file}")
    return 0


def check(options: MapNew) -> None:
    """Raise an error for impossible options."""
    if options.file.exists():
        raise UsageError(f"{options.file}: is already there; name another file")
    check_writable(options.file.parent)
    if options.like and (options.crosswalks or any(getattr(options, name) is not None for name in LIMITS)):
        raise UsageError("--like: a copy has its own length, width and crosswalks; leave them out, or leave out --like")
    for name, (least, most) in LIMITS.items():
        value = getattr(options, name)
        if value is not None and not least <= value <= most:
            raise UsageError(f"--{name} must lie in [{least:g}, {most:g}] m, not {value:g}")
    if not all(map(isfinite, options.crosswalks)):
        raise UsageError("--crosswalks must be finite numbers")


def _street(options: MapNew) -> str:
    length, width = (getattr(options, name) or usual for name, usual in USUAL.items())
    return street_map(length, width, options.crosswalks or (length / 2,))


def _places(options: MapNew) -> int:
    return len(options.crosswalks) or 1
