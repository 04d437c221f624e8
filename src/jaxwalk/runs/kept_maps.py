"""The maps that a run folder keeps, so that it can be copied to another machine and no change of a map file affects it.

``maps.json`` is a list with name, hash and text of each map, in the order of the configuration's ``maps``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import TypeAdapter, ValidationError

from jaxwalk.writing import write_whole

if TYPE_CHECKING:
    from jaxwalk.maps import MapText  # JAX comes with it, so functions import it when they need it

MAPS = "maps.json"
"""Name of the file in a run folder."""
COPY = "copy it again from where the run was made, or train anew"


class KeptMapsError(ValueError):
    """A run folder's maps aren't those that it was trained on. The message says what to do, in one line."""


def to_stderr(line: str) -> None:
    """Print a warning on standard error."""
    print(f"warning: {line}", file=sys.stderr)


def keep_maps(folder: Path, maps: Sequence[MapText]) -> None:
    """Write the maps into a run folder."""
    write_whole(folder / MAPS, json.dumps([asdict(x) for x in maps], indent=2) + "\n")


def kept_maps(folder: Path, named: Sequence[str], tell: Callable[[str], None]) -> tuple[MapText, ...]:
    """Return the maps that a run folder keeps.

    Args:
        folder: the run folder.
        named: the maps that its configuration names. They are read if the folder keeps none.
        tell: called with a warning if the folder keeps none, as those of older versions.

    Raises:
        KeptMapsError: a kept map was edited, ``maps.json`` is damaged, or the configuration names other maps.
        MapError: the folder keeps none, and a named map can't be read.
    """
    from jaxwalk.maps import map_name, read_map, text_hash

    path = folder / MAPS
    if not path.is_file():
        tell(f"{folder}: keeps no maps, as it is of an older version; {', '.join(named)} may have changed since")
        return tuple(map(read_map, named))
    maps = _read(path)
    for found in maps:
        if text_hash(found.text or "") != found.hash:
            raise KeptMapsError(f"{path}: the map {found.name} was edited (its hash is not {found.hash}); {COPY}")
    if [x.name for x in maps] != [map_name(name) for name in named]:
        raise KeptMapsError(f"{path}: the configuration names {', '.join(named)}, but no such map is kept here; {COPY}")
    return maps


def _read(path: Path) -> tuple[MapText, ...]:
    from jaxwalk.maps import MapText

    try:
        return TypeAdapter(tuple[MapText, ...]).validate_json(path.read_bytes(), strict=True)
    except ValidationError as error:
        raise KeptMapsError(f"{path}: damaged ({error.errors(include_url=False)[0]['msg']}); {COPY}") from error
