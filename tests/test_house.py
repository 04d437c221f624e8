"""The rules of the house that no other tool checks: sizes, names, circles, words. See CONTRIBUTING.md.

Each rule has a set of exceptions, which must shrink: one that is no longer needed fails its test.
"""

from __future__ import annotations

import ast
import re
from collections import Counter, defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src"
FILES = sorted((SRC / "jaxwalk").rglob("*.py"))

LINES, FUNCTION_LINES, PARAMETERS, NESTING = 300, 50, 6, 2
"""The most lines of a module and of a function, parameters (``self`` apart), and compound statements in each other."""

LONG_MODULES: set[str] = set()
LONG_FUNCTIONS: set[str] = set()
MANY_PARAMETERS: set[str] = set()
DEEP_FUNCTIONS: set[str] = {
    "jaxwalk.bench.quantities._shares", "jaxwalk.bench.starting.watch",
    "jaxwalk.evaluation.reading._check_sizes", "jaxwalk.evaluation.results.evaluate_grid",
    "jaxwalk.report.figures.surrogates.surrogates",
    "jaxwalk.report.paper_tables.ablation", "jaxwalk.report.paper_tables.approach",
    "jaxwalk.report.paper_tables.baselines", "jaxwalk.runs.study._do", "jaxwalk.sim.reward.check_weights",
}  # fmt: skip
SAME_MODULES: set[str] = set()
SAME_CLASSES: set[str] = set()
CIRCLES: set[str] = set()
ODD_DOCSTRINGS: set[str] = set()
ODD_WORDS: set[str] = set()

FORBIDDEN = re.compile(r"\b(so many|whom|mend|mends|mended|glance|glances|gone on with)\b", re.IGNORECASE)
"""Words for which there are plainer ones."""

Function = ast.FunctionDef | ast.AsyncFunctionDef
COMPOUND = (ast.For, ast.AsyncFor, ast.While, ast.If, ast.With, ast.AsyncWith, ast.Try, ast.TryStar, ast.Match)


@cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


@pytest.fixture(scope="module", autouse=True)
def trees_are_forgotten():
    """All trees together take 200 MB."""
    yield
    _tree.cache_clear()


def _module(file: Path) -> str:
    """The name that imports it."""
    parts = file.relative_to(SRC).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _functions() -> Iterator[tuple[str, Function]]:
    """Every function with its place."""
    for file in FILES:
        for node in ast.walk(_tree(file)):
            if isinstance(node, Function):
                yield f"{_module(file)}.{node.name}", node


def check_exceptions(found: set[str], allowed: set[str], rule: str) -> None:
    """Fail for what breaks a rule without being an exception, and for exceptions that are no longer needed."""
    assert not found - allowed, f"{rule}: {sorted(found - allowed)}"
    assert not allowed - found, f"no exception any more, take it out of the list: {sorted(allowed - found)}"


def test_no_module_is_long():
    found = {_module(file) for file in FILES if len(file.read_text(encoding="utf-8").splitlines()) > LINES}
    check_exceptions(found, LONG_MODULES, f"modules of more than {LINES} lines")


def test_no_function_is_long():
    found = {name for name, node in _functions() if (node.end_lineno or 0) - node.lineno + 1 > FUNCTION_LINES}
    check_exceptions(found, LONG_FUNCTIONS, f"functions of more than {FUNCTION_LINES} lines")


def test_no_function_has_many_parameters():
    found = {name for name, node in _functions() if _parameters(node) > PARAMETERS}
    check_exceptions(found, MANY_PARAMETERS, f"functions of more than {PARAMETERS} parameters")


def _parameters(node: Function) -> int:
    given = node.args
    names = [x.arg for x in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return len(names) - (names[:1] in (["self"], ["cls"]))


def test_statements_are_not_nested_deeply():
    found = {name for name, node in _functions() if _depth(node.body) > NESTING}
    check_exceptions(found, DEEP_FUNCTIONS, f"functions with compound statements nested more than {NESTING} deep")


def _depth(body: list[ast.stmt]) -> int:
    """How deeply compound statements are nested; an ``elif`` is as deep as its ``if``. Functions inside count anew."""
    return max((1 + _depth_inside(node) for node in body if isinstance(node, COMPOUND)), default=0)


def _depth_inside(node: ast.stmt) -> int:
    deepest = 0
    for name, value in ast.iter_fields(node):
        if isinstance(node, ast.If) and name == "orelse" and len(value) == 1 and isinstance(value[0], ast.If):
            deepest = max(deepest, _depth(value) - 1)
        elif name in ("body", "orelse", "finalbody"):
            deepest = max(deepest, _depth(value))
        elif name in ("handlers", "cases"):
            deepest = max([deepest, *(_depth(part.body) for part in value)])
    return deepest


def test_no_two_modules_of_one_name():
    """Commands apart: they are named after what they run."""
    places = defaultdict(set)
    for file in FILES:
        name = _module(file)
        if file.stem != "__main__" and file.parent.name != "cli":
            places[name.rpartition(".")[2]].add(name)
    check_exceptions({name for name, found in places.items() if len(found) > 1}, SAME_MODULES, "modules of one name")


def test_no_two_classes_of_one_name():
    """Options of commands apart: they are named after their commands."""
    places = defaultdict(list)
    for file in FILES:
        for node in ast.walk(_tree(file)):
            if isinstance(node, ast.ClassDef) and "options" not in file.parts:
                places[node.name].append(_module(file))
    check_exceptions({name for name, found in places.items() if len(found) > 1}, SAME_CLASSES, "classes of one name")


def test_no_circle_of_imports():
    """Also between modules of one room, and through imports inside functions; ``import-linter`` has the floors."""
    imports = _imports()
    found = {" ".join(sorted(circle)) for circle in _circles(imports)}
    check_exceptions(found, CIRCLES, "modules that import each other in a circle")


def _imports() -> dict[str, set[str]]:
    """By module, the modules that it imports by name, wherever it does; not those only for type checkers."""
    modules = {_module(file) for file in FILES}
    found: dict[str, set[str]] = {}
    for file in FILES:
        tree = _tree(file)
        skipped = {id(part) for node in ast.walk(tree) if _for_types(node) for part in ast.walk(node)}
        names = {name for node in ast.walk(tree) if id(node) not in skipped for name in _imported(node, modules)}
        found[_module(file)] = names - {_module(file)}
    return found


def _for_types(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def _imported(node: ast.AST, modules: set[str]) -> set[str]:
    """The modules of ours that a statement imports: ``from room import module`` is the module, not the room."""
    if isinstance(node, ast.Import):
        return {alias.name for alias in node.names} & modules
    if isinstance(node, ast.ImportFrom) and node.module in modules:
        inner = {f"{node.module}.{alias.name}" for alias in node.names}
        return (inner & modules) | ({node.module} if inner - modules else set())
    return set()


def _circles(imports: dict[str, set[str]]) -> list[set[str]]:
    """Groups of modules each of which reaches all others of its group."""
    reach = {name: _reached(name, imports) for name in imports}
    groups = {frozenset(other for other in reach[name] if name in reach[other]) for name in imports}
    return [set(group) for group in groups if group]


def _reached(start: str, imports: dict[str, set[str]]) -> set[str]:
    found, rest = set(), [start]
    while rest:
        new = imports[rest.pop()] - found
        found |= new
        rest += new
    return found


def _docstrings(file: Path) -> Iterator[tuple[int, str]]:
    """Every string that stands on its own: docstrings, also those of fields and constants."""
    for node in ast.walk(_tree(file)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno, node.value.value


def test_no_docstring_begins_with_of():
    found = {_module(file) for file in FILES for _, text in _docstrings(file) if text.startswith("Of ")}
    check_exceptions(found, ODD_DOCSTRINGS, 'modules with docstrings that begin with "Of "')


def test_plain_words():
    """In code, comments, messages and what stands beside the code."""
    beside = [path for kind in ("html", "js", "css", "toml") for path in (SRC / "jaxwalk").rglob(f"*.{kind}")]
    texts = {str(path.relative_to(SRC)): path.read_text(encoding="utf-8") for path in [*FILES, *beside]}
    check_exceptions(
        {name for name, text in texts.items() if FORBIDDEN.search(text)}, ODD_WORDS, f"words ({FORBIDDEN.pattern})"
    )


@pytest.mark.parametrize(
    ("code", "depth"),
    [
        ("x = 1", 0),
        ("if a:\n    b", 1),
        ("if a:\n    b\nelif c:\n    d\nelif e:\n    f", 1),
        ("if a:\n    b\nelse:\n    if c:\n        d\n    e", 2),
        ("for a in b:\n with c:\n  try:\n   d\n  except E:\n   if f:\n    g", 4),
        ("def a():\n    if b:\n        c", 0),
    ],
)
def test_depth_is_counted(code, depth):
    assert _depth(ast.parse(code).body) == depth


def test_a_circle_is_found():
    assert _circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == [{"b", "c"}]


def _names_bound(file: Path) -> Iterator[str]:
    """The names that a module gives to values outside of blocks, one after the other."""
    for node in _tree(file).body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        yield from (x.id for target in targets for x in ast.walk(target) if _is_bound(x))


def _is_bound(x: ast.AST) -> bool:
    return isinstance(x, ast.Name) and isinstance(x.ctx, ast.Store)


def test_a_module_gives_a_name_to_one_thing_only():
    """The second one silently takes the place of the first."""
    again = {
        f"{file.relative_to(SRC.parent)}: {name}"
        for file in [*FILES, *sorted((SRC.parent / "tests").rglob("*.py"))]
        for name, times in Counter(_names_bound(file)).items()
        if times > 1
    }
    assert again == set()
