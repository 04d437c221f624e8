"""The error of an import, also where a package of another extra is needed."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType


class ImportRefusal(ValueError):
    """A source can't be imported. The message is one line: what, where, and what to do."""


def needed(name: str, path: Path, extra: str) -> ModuleType:
    """Return a module of an extra. Raise ImportRefusal if it isn't installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise ImportRefusal(f'{path}: reading it needs {name}; install it by: pip install "jaxwalk[{extra}]"') from None
