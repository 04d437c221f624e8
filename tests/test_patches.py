"""What tests patch is there. A quick look at all of them, since long tests seldom run and would break unseen."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

TESTS = Path(__file__).parent
ADVICE = "a test patches a name of jaxwalk that is gone: rename it there too"


def _patches(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and full name of whatever of jaxwalk is patched by its name, or as an attribute of what is imported."""
    imported = dict(_imported(tree))
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "setattr"):
            continue
        if node.keywords:  # raising=False: it needn't be there
            continue
        place, *rest = (arg.value if isinstance(arg, ast.Constant) else ast.unparse(arg) for arg in node.args)
        if isinstance(node.args[0], ast.Constant):
            name = place
        elif len(rest) == 2 and isinstance(node.args[1], ast.Constant) and place in imported:
            name = f"{imported[place]}.{rest[0]}"
        else:
            continue
        if name.startswith("jaxwalk."):
            yield node.lineno, name


def _imported(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """What a file calls something that it imports, and its full name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from ((alias.asname or alias.name, f"{node.module}.{alias.name}") for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.asname, alias.name) for alias in node.names if alias.asname)


def _found(name: str) -> Any:
    """What a full name means: a module, or an attribute of what is before the last dot. Raise AttributeError."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        place, _, attribute = name.rpartition(".")
        return getattr(_found(place), attribute)


def _gone(tree: ast.Module) -> Iterator[tuple[int, str]]:
    for line, name in _patches(tree):
        try:
            _found(name)
        except AttributeError:
            yield line, name


def test_what_tests_patch_is_there():
    patches, gone = 0, []
    for path in sorted(TESTS.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        patches += len(list(_patches(tree)))
        gone += [f"{path.relative_to(TESTS)}:{line}: {name}" for line, name in _gone(tree)]
    assert patches > 100
    assert not gone, f"{ADVICE}: {gone}"


@pytest.mark.parametrize("name", ["jaxwalk.writing.nothing", "jaxwalk.nowhere.whole"])
def test_a_name_that_is_gone_is_found(name):
    place, _, attribute = name.rpartition(".")
    room, _, module = place.rpartition(".")
    assert list(_gone(ast.parse(f"monkeypatch.setattr('{name}', 1)"))) == [(1, name)]
    by_object = ast.parse(f"from {room} import {module}\nmonkeypatch.setattr({module}, '{attribute}', 1)")
    assert list(_gone(by_object)) == [(2, name)]
