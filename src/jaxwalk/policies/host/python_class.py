"""Drivers in plain Python: ``module:Class`` or ``path/to/file.py:Class``. Naming one runs its code."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from jaxwalk.policies.host.driver import DriverError

OBSERVES = "paper"
"""Observation set of a driver that names none."""


def load_class(name: str) -> tuple[Any, str]:
    """Return a driver made by the class (or function) with this name, and the observation set that it reads.

    Raises DriverError if the class can't be imported or called, or has no method ``act``.
    """
    home, _, attribute = name.rpartition(":")
    with _failures(name, f"importing {home}"):
        module = _file_module(Path(home)) if home.endswith(".py") else _module(home)
        make = getattr(module, attribute, None)
    if not callable(make):
        raise DriverError(f"{name}: {home} has no class {attribute}; check the name")
    with _failures(name, f"{attribute}()"):
        driver = make()
    with _failures(name, f"looking at what {attribute}() returned"):  # any of these may be a property, so code
        acts = callable(getattr(driver, "act", None))
        observes = str(getattr(driver, "observes", OBSERVES))
        hasattr(driver, "reset")
    if not acts:
        raise DriverError(f"{name}: has no method act(observation); give it one that returns an array (episodes, 2)")
    return driver, observes


def _module(name: str) -> ModuleType:
    """Import a module; the working folder is searched first."""
    with _importable(Path.cwd()):
        return import_module(name)


def _file_module(path: Path) -> ModuleType:
    """Import a file as a module. It may import other files of its folder."""
    spec = spec_from_file_location(f"jaxwalk_driver_{path.stem}", path)  # the prefix, because a file may be torch.py
    if not path.is_file() or spec is None or spec.loader is None:
        raise FileNotFoundError(f"no file {path}")
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # as an import does: dataclasses need their module there
    with _importable(path.parent.absolute()):
        spec.loader.exec_module(module)
    return module


@contextmanager
def _importable(folder: Path) -> Iterator[None]:
    sys.path.insert(0, os.fspath(folder))
    try:
        yield
    finally:
        sys.path.remove(os.fspath(folder))


@contextmanager
def _failures(name: str, doing: str) -> Iterator[None]:
    """Turn any error of the driver's own code into a DriverError that says what the code was doing."""
    try:
        yield
    except Exception as error:
        raise DriverError(
            f"{name}: {doing} raised {type(error).__name__}: {error}; fix it or check the name"
        ) from error
