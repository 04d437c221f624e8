"""A file of scripted tests, TOML or OpenSCENARIO XML: its ending decides."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from jaxwalk.maps import MapText
from jaxwalk.scenarios.crash_file import load_crash_suite
from jaxwalk.scenarios.crash_suite import CrashSuite
from jaxwalk.scenarios.xosc.script_reading import read_xosc

XOSC = ".xosc"
"""How the names of OpenSCENARIO files end."""


class ScriptFile(NamedTuple):
    """The tests of a file, and where they take place."""

    suite: CrashSuite
    track: MapText | None = None
    """The street, if the file describes it; None if the suite names it."""


def read_script(name_or_path: str | Path) -> ScriptFile:
    """Return a suite that ships with jaxwalk, by its name, or that of a .toml or .xosc file. Raises CrashFileError."""
    if str(name_or_path).endswith(XOSC):
        found = read_xosc(Path(name_or_path))
        return ScriptFile(found.suite, found.track)
    return ScriptFile(load_crash_suite(name_or_path))
