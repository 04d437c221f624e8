"""The Python modules and packages that a stranger's driver loads: they come with its files, and are forgotten after."""

from __future__ import annotations

import os
import site
import sys
import sysconfig
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import invalidate_caches
from pathlib import Path

from jaxwalk.policies.host.driver import DriverError

OURS = Path(__file__).parents[2]
"""Folder of the package jaxwalk, which needn't lie with installed packages."""


@contextmanager
def modules_of(folder: Path, home: Path) -> Iterator[Callable[[], None]]:
    """Let drivers import modules of one folder and installed packages; forget what they loaded from elsewhere after it.

    Another folder's driver can then have modules of the same names.

    Args:
        folder: where the driver's modules are.
        home: the folder that messages name, of which ``folder`` may be a copy.

    Yields:
        A function that checks what was loaded so far; at the end it is called once more.

    Raises:
        DriverError: a module or package that was loaded meanwhile is neither installed nor of the folder. Its message
            begins with the name of the module.
    """
    before = set(sys.modules)

    def check() -> None:
        _check({*sys.modules} - before, folder.resolve(), home)

    try:
        yield check
        check()
    finally:
        _forget({*sys.modules} - before)


def _forget(loaded: set[str]) -> None:
    """Forget the modules and packages that aren't installed."""
    installed = _installed()
    for name, places in [(name, _places(name)) for name in loaded]:
        if places and not any(_within(place, installed) for place in places):
            del sys.modules[name]
    invalidate_caches()


def _check(loaded: set[str], folder: Path, home: Path) -> None:
    """Raise DriverError for a module or package that is neither installed nor of the folder."""
    allowed = (folder, *_installed())
    for name in sorted(loaded):
        places = _places(name)
        if places and not any(_within(place, allowed) for place in places):
            what, inside = ("package", ", with an __init__.py") if places[0].is_dir() else ("module", "")
            there = f"the driver imports this {what} from {places[0].parent}"
            raise DriverError(f"{name}: {there}; put it into {home}{inside}")


def _places(name: str) -> tuple[Path, ...]:
    """Return the file of a loaded module or package, or the folders of a package without ``__init__.py``.

    There are none for modules that are built in.
    """
    module = sys.modules.get(name)
    file = getattr(module, "__file__", None)
    found = [file] if isinstance(file, str) else list(getattr(module, "__path__", None) or ())
    return tuple(Path(os.path.normpath(each)) for each in found if isinstance(each, str) and os.path.isabs(each))


def _installed() -> tuple[Path, ...]:
    """Return the folders of Python, of installed packages and of jaxwalk."""
    paths = (sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib"))
    return tuple(Path(path) for path in (*paths, *site.getsitepackages(), site.getusersitepackages(), OURS))


def _within(file: Path, folders: tuple[Path, ...]) -> bool:
    """Return whether a file is in one of the folders. Installers may put links there, so both ends are looked at."""
    return any(file.is_relative_to(place) or file.resolve().is_relative_to(place.resolve()) for place in folders)
