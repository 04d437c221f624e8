"""Whose shapes are checked in tests: see `tests/conftest.py`, which changes a part of jaxtyping (0.3.11) for that."""

from __future__ import annotations

import ast

from jaxtyping import _import_hook

SOURCE = """
def function():
    def inner(): ...

class Kind:
    def method(self):
        def inner(): ...
"""


def test_functions_inside_others_are_not_checked():
    transformer = _import_hook.JaxtypingTransformer(typechecker=_import_hook.Typechecker(None))
    tree = transformer.visit(ast.parse(SOURCE))
    named = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    assert {node.name for node in named if node.decorator_list} == {"function", "Kind", "method"}
