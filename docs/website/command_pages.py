"""The page of all commands, made from the table of commands and the declarations that the parser reads."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin, get_type_hints

from jaxwalk.cli.arguments import RENAMED
from jaxwalk.cli.commands import COMMANDS

HEAD = """\
# Commands

For people who use the command line: every command with every option, from the declarations that the program itself
reads. `jaxwalk COMMAND --help` prints the same; [the command line](../command-line.md) tells what the commands do. A
word in capitals stands for a value, and `[...]` for further ones.

`python -m jaxwalk` is the same as `jaxwalk`, for the Python that runs it.
"""

NAMED = re.compile(r"docs: ([a-z-]+)")
"""A page of docs/, as texts of the command line name it."""


def commands_page() -> str:
    """Return the page."""
    parts = [HEAD]
    for command in COMMANDS:
        parts += [
            f"## jaxwalk {command.name}\n",
            f"{_plain(inspect.getdoc(command.options) or '')}\n",
            *_table(command.options),
        ]
        for old, new in RENAMED.get(command.name, {}).items():
            parts.append(f"`--{old.replace('_', '-')}` of earlier versions is written `{new}` now.\n")
    return "\n".join(parts)


def _table(options: type) -> Iterator[str]:
    """Yield the lines of a table of the options of a command."""
    yield "| option | value | default | what it does |"
    yield "| --- | --- | --- | --- |"
    texts, hints = field_texts(options), get_type_hints(options, include_extras=True)
    for field in dataclasses.fields(options):
        given = [each for each in getattr(hints[field.name], "__metadata__", ()) if hasattr(each, "metavar")]
        about = given[0] if given else None
        cells = [_flag(field.name, hints[field.name], about), _value(hints[field.name], about), _default(field, about)]
        yield f"| {' | '.join(cells)} | {_plain(texts[field.name])}{_choices(hints[field.name])} |"
    yield ""


def field_texts(options: type) -> dict[str, str]:
    """Return the docstring of each field of a class of options."""
    tree = ast.parse(inspect.getsource(options)).body[0]
    assert isinstance(tree, ast.ClassDef)
    found = {}
    for node, after in zip(tree.body, tree.body[1:], strict=False):
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and isinstance(after, ast.Expr):
            found[node.target.id] = " ".join(str(ast.literal_eval(after.value)).split())
    return found


def _flag(name: str, hint: Any, about: Any) -> str:
    positional = "Positional" in repr(getattr(hint, "__metadata__", ()))
    return "" if positional else f"`--{(getattr(about, 'name', None) or name).replace('_', '-')}`"


def _value(hint: Any, about: Any) -> str:
    metavar = getattr(about, "metavar", None)
    if metavar is None and _literal(hint):
        return "a name"
    return f"`{metavar}`" if metavar else ""


def _default(field: dataclasses.Field[Any], about: Any) -> str:
    hint = getattr(about, "help_behavior_hint", None)
    if hint:
        return _plain(str(hint).removeprefix("(default: ").removesuffix(")"))
    if field.default is dataclasses.MISSING:
        return "needed"
    return "none" if field.default in (None, (), False) else f"{field.default}"


def _choices(hint: Any) -> str:
    names = _literal(hint)
    return f" One of {', '.join(f'`{name}`' for name in names)}." if names else ""


def _literal(hint: Any) -> tuple[str, ...]:
    """Return the names among which an option chooses; () for another one."""
    if get_origin(hint) is Literal:
        return tuple(map(str, get_args(hint)))
    inner = get_args(hint)
    if hasattr(hint, "__metadata__"):
        inner = inner[:1]
    return next((names for each in inner if (names := _literal(each))), ())


def _plain(text: str) -> str:
    """Return a docstring as Markdown in one cell or paragraph."""
    text = NAMED.sub(r"docs: [\1](../\1.md)", text)
    lines = text.replace("|", r"\|").replace("``", "`")
    return lines.replace("<", "&lt;").replace("*", r"\*") if "`" not in lines else lines
