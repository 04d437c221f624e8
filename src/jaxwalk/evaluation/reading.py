"""Documents are read back here: whatever a file says, the program gets a complete typed document, or one message."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from textwrap import shorten
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from jaxwalk.evaluation.results import HEADLINE, SCHEMA, Cell, Results

LARGEST = 1e39
"""No number of ours is larger; larger ones would overflow where percentages are made of them."""
LONGEST = 200
"""Characters of a field's name, and of what is wrong with it, in a message."""

T = TypeVar("T")


class DocumentError(ValueError):
    """A file that is no whole document of this version; the message names the file and the field."""


def read_json(path: Path, advice: str) -> Any:
    """Return the content of a JSON file, or None if there is no file.

    Raises DocumentError, which ends with the advice, if the file is not JSON or has a number that is not finite.
    """
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_bytes().decode("utf-8"))
        wrong = _wrong_number(content, ())
    except (ValueError, RecursionError) as error:
        raise DocumentError(f"{path}: damaged ({error}); {advice}") from error
    if wrong is not None:
        raise DocumentError(f"{path}: damaged ({_place(wrong)} is not a finite number); {advice}")
    return content


def as_document(kind: type[T], content: Any, path: Path, advice: str) -> T:
    """Return the content as a typed document.

    Args:
        kind: a frozen dataclass, or another type that pydantic knows.
        content: what `read_json` returned.
        path: the file, for messages.
        advice: what the user can do about a damaged file.

    Raises:
        DocumentError: a field is missing, unknown or of another type.
    """
    try:
        return TypeAdapter(kind).validate_json(json.dumps(content))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where, what = _place(first["loc"]), shorten(first["msg"], LONGEST)
        raise DocumentError(f"{path}: damaged ({where}: {what}); {advice}") from error


def as_results(content: Any, path: Path, advice: str) -> Results:
    """Return a file's content as typed results.

    Raises:
        DocumentError: the file is of another schema, or a field is missing, unknown or of another type.
    """
    if not isinstance(content, Mapping) or content.get("schema") != SCHEMA:
        raise DocumentError(f"{path}: of another version (its schema is not {SCHEMA}); {advice}")
    nested = {name: value for name, value in content.items() if name != "schema"}
    if isinstance(nested.get("cells"), list):
        nested["cells"] = [_nested(cell) for cell in nested["cells"]]
    results = as_document(Results, nested, path, advice)
    for number, cell in enumerate(results.cells):
        same = cell.as_dict()
        wrong = [name for name in HEADLINE if content["cells"][number].get(name) != same[name]]
        if wrong:
            raise DocumentError(f"{path}: damaged (cells.{number}.{wrong[0]} is not the summary's); {advice}")
    return results


def _nested(cell: Any) -> Any:
    """Return a cell of a file with its metrics under ``summary``, and without the headline, which repeats some."""
    if not isinstance(cell, dict):
        return cell
    own = {field.name for field in fields(Cell)} - {"summary"}
    rest = {name: value for name, value in cell.items() if name not in own and name not in HEADLINE}
    return {name: value for name, value in cell.items() if name in own} | {"summary": rest}


def _wrong_number(content: Any, place: tuple[str | int, ...]) -> tuple[str | int, ...] | None:
    """Return where the first number stands that is infinite, too large or NaN; None if there is none."""
    if isinstance(content, (int, float)) and not abs(content) <= LARGEST:
        return place
    inner = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    found = (_wrong_number(value, (*place, name)) for name, value in inner)
    return next((wrong for wrong in found if wrong is not None), None)


def _place(path: tuple[str | int, ...]) -> str:
    """Return a field's place in a document, such as ``cells.3.outcomes.goal``."""
    names = [str(part) for part in path if part != "summary"]
    return shorten(".".join(names), LONGEST) if names else "the document"
