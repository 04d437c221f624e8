"""The file of a training: TOML that names a recipe and what differs from it. ``docs/recipes.md`` describes it.

This module imports no JAX, so that a wrong file is refused at once.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from textwrap import shorten
from typing import Any

from pydantic import TypeAdapter, ValidationError

from jaxwalk.recipes.experiment import Experiment
from jaxwalk.sim.sim_config import WORLDS, rules_of

MOST_BYTES = 1_000_000
"""Largest size of the file [bytes]."""
MAP_FILES = (".toml", ".json")
"""Endings of maps that are files; their paths are relative to the folder of the training's file."""
SHOWN = 80
"""Longest quotation of a wrong value in a message [characters]."""


class ExperimentFileError(ValueError):
    """A file that describes no training. The message names file and field, in one line."""


def load_experiment(path: str | Path, recipes: Mapping[str, Experiment]) -> Experiment:
    """Return the training that a TOML file describes: its recipe with the fields that the file changes.

    Args:
        path: the file. ``recipe`` (default: fast) and ``world`` in it are names, all else are fields of `Experiment`.
        recipes: the recipes that it may name.

    Raises:
        ExperimentFileError: it can't be read, or a field is unknown or impossible.
    """
    return described_experiment(read_table(path), path, recipes)


def described_experiment(
    table: Mapping[str, Any], path: str | Path, recipes: Mapping[str, Experiment], *, within: str = ""
) -> Experiment:
    """Return the training that a table of a file describes, as `load_experiment` does.

    Args:
        table: what the file says of the training.
        path: the file, which messages name, and beside which maps and archives are.
        recipes: the recipes that the table may name.
        within: where in the file the table is, such as ``training.``; messages name it.

    Raises:
        ExperimentFileError: a field is unknown or impossible.
    """
    path, table, where = Path(path), dict(table), f"{path}: {within}"
    base = _base(where, table, recipes)
    content = _experiments().dump_python(base, mode="json")
    for role in _inner(table, "train", "roles"):
        if role not in base.train.roles:
            known = ", ".join(base.train.roles)
            raise ExperimentFileError(f"{where}train.roles.{role}: there is no such role; there are {known}")
    merged = merged_tables(content, table)
    try:
        found = _experiments().validate_json(json.dumps(merged, default=str), strict=True)
    except ValidationError as error:
        fault = dict(error.errors(include_url=False)[0])
        raise ExperimentFileError(f"{where}{explained_fault(fault, content)}; correct the file") from None
    if found.archive_share != base.archive_share and not found.archives:
        raise ExperimentFileError(f"{where}archive_share: there are no archives; add archives, or leave it out")
    archives = tuple(str((path.parent / name).absolute()) for name in found.archives)
    maps = tuple(_beside(path, name) for name in found.maps) if "maps" in table else found.maps
    return replace(found, maps=maps, archives=archives)


def read_table(path: str | Path) -> dict[str, Any]:
    """Return the content of a TOML file. Raise ExperimentFileError if it can't be read."""
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise ExperimentFileError(f"{path}: not a regular file; check the path")
        if path.stat().st_size > MOST_BYTES:
            raise ExperimentFileError(f"{path}: larger than {MOST_BYTES:,} bytes, which no training needs")
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except OSError as error:
        raise ExperimentFileError(f"{path}: cannot be read ({error.strerror}); check the path") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise ExperimentFileError(f"{path}: not TOML that can be read ({error}); correct the file") from None


def _base(where: str, table: dict[str, Any], recipes: Mapping[str, Experiment]) -> Experiment:
    """Return the recipe that a table names, in the world that it names; both names are removed from ``table``."""
    name, world = table.pop("recipe", "fast"), table.pop("world", None)
    if name not in list(recipes):
        raise ExperimentFileError(f"{where}recipe: there is no {quoted_value(name)}; there are {', '.join(recipes)}")
    if world is not None and world not in list(WORLDS):
        raise ExperimentFileError(f"{where}world: there is no {quoted_value(world)}; there are {', '.join(WORLDS)}")
    base, maps = recipes[name], table.get("maps")
    if world is None and not isinstance(maps, list):
        return base
    return replace(base, sim=rules_of(world, maps if isinstance(maps, list) else base.maps, base.sim))


def _inner(table: Any, *names: str) -> Any:
    """Return a table inside another one; {} where there is none."""
    for name in names:
        table = table.get(name, {}) if isinstance(table, dict) else {}
    return table if isinstance(table, dict) else {}


def merged_tables(base: Any, changes: Any) -> Any:
    """Return tables with the values that others change."""
    if isinstance(base, dict) and isinstance(changes, dict):
        return base | {name: merged_tables(base.get(name), value) for name, value in changes.items()}
    return changes


def explained_fault(fault: dict[str, Any], known: Any) -> str:
    """Return one pydantic fault as a line that begins with the field. ``known``: the fields of the recipe."""
    parts = [part for part in fault["loc"] if part not in ("int", "float")]  # members of unions
    field = ".".join(map(str, parts))
    if fault["type"] == "unexpected_keyword_argument":
        fields = _inner(known, *map(str, parts[:-1]))
        near = get_close_matches(str(parts[-1]), fields, 1)
        return f"{field}: there is no such field; " + (f"perhaps {near[0]} is meant" if near else "leave it out")
    message = str(fault["msg"]).removeprefix("Value error, ").replace("Input should", "must")
    if fault["type"] == "value_error":  # the message names the field and the value
        return f"{field}: {message}" if field else message
    return f"{field}: {message}, not {quoted_value(fault['input'])}"


def quoted_value(value: Any) -> str:
    """Return a wrong value for a message, cut off if it is long."""
    return shorten(repr(value), SHOWN)


def _beside(path: Path, name: str) -> str:
    """Return a map's name, or for a file its absolute path, so that the run can be resumed from anywhere."""
    return str((path.parent / name).absolute()) if name.endswith(MAP_FILES) else name


@cache
def _experiments() -> Any:
    """Return a TypeAdapter[Experiment]."""
    return TypeAdapter(Experiment)
