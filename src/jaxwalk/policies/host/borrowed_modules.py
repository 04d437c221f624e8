"""The Python modules that a stranger's driver loads: they must come with its files, and are forgotten afterwards."""

from __future__ import annotations

import os
import site
import sys
import sysconfig
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import invalidate_caches
from pathlib import Path
from tempfile import TemporaryDirectory

from jaxwalk.policies.host.driver import DriverError

OURS = Path(__file__).parents[2]
"""Folder of the package jaxwalk, which needn't lie with installed packages."""


@contextmanager
def modules_of(folder: Path) -> Iterator[Callable[[], None]]:
    """Let drivers import modules of one folder and installed packages; forget what they loaded from elsewhere after it.

    Another folder's driver can then have modules of the same names. Compiled code is neither read from the folder nor
    written into it.

    Yields:
        A function that checks what was loaded so far; at the end it is called once more.

    Raises:
        DriverError: a module that was loaded meanwhile is neither installed nor of the folder. Its message begins with
            the module's name.
    """
    before, cached = set(sys.modules), sys.pycache_prefix
    with TemporaryDirectory() as away:
        sys.pycache_prefix = away
        try:
            yield lambda: _check({*sys.modules} - before, folder.resolve())
            _check({*sys.modules} - before, folder.resolve())
        finally:
            sys.pycache_prefix = cached
            _forget({*sys.modules} - before)


def _forget(loaded: set[str]) -> None:
    """Forget the modules that aren't installed."""
    installed = _installed()
    for name, file in [(name, _file(name)) for name in loaded]:
        if file is not None and not _within(file, installed):
            del sys.modules[name]
    invalidate_caches()


def _check(loaded: set[str], folder: Path) -> None:
    """Raise DriverError for a module that is neither installed nor of the folder."""
    allowed = (folder, *_installed())
    for name in sorted(loaded):
        file = _file(name)
        if file is not None and not _within(file, allowed):
            raise DriverError(f"{name}: the driver imports this module from {file.parent}; put it into {folder}")


def _file(name: str) -> Path | None:
    """Return the file of a loaded module; None if it has none, as modules that are built in."""
    file = getattr(sys.modules.get(name), "__file__", None)
    return Path(os.path.normpath(file)) if isinstance(file, str) and os.path.isabs(file) else None


def _installed() -> tuple[Path, ...]:
    """Return the folders of Python, of installed packages and of jaxwalk."""
    paths = (sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib"))
    return tuple(Path(path) for path in (*paths, *site.getsitepackages(), site.getusersitepackages(), OURS))


def _within(file: Path, folders: tuple[Path, ...]) -> bool:
    """Return whether a file is in one of the folders. Installers may put links there, so both ends are looked at."""
    return any(file.is_relative_to(place) or file.resolve().is_relative_to(place.resolve()) for place in folders)
