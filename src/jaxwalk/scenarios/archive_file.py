"""Files of kept scenarios: safetensors with the points, and a text header with the street. No code is in them."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np
import pydantic
import safetensors
import safetensors.numpy

from jaxwalk.maps import MapText, reference, text_of
from jaxwalk.scenarios.archived import Archived
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.writing import write_whole

FORMAT: Final = 1
"""Version of the file format."""
HEADER: Final = "jaxwalk-scenarios"
"""The header's entry that jaxwalk writes and reads."""
SCENARIOS: Final = "scenarios.safetensors"
"""Name of the file in the folder of a search."""
MOST: Final = 100_000
"""Most scenarios in a file."""
ADVICE: Final = "copy it again, or make it anew"


class ArchiveError(ValueError):
    """A file of scenarios can't be used. The message names it, says what is wrong and what to do, in one line."""


@dataclass(frozen=True)
class ArchiveHeader:
    """What a file says about its scenarios."""

    __pydantic_config__: ClassVar = {"extra": "forbid"}

    format: int
    maps: tuple[MapText, ...]
    """The maps; one that ships with jaxwalk, or that it makes from a number, without its text."""
    sim: SimConfig
    seed: int
    """The seed of the keys."""
    about: dict[str, Any]
    """What else the writer says, as JSON."""


def write_archive(path: Path, archived: Archived, about: dict[str, Any]) -> None:
    """Write scenarios, with anything else to say ``about`` them as JSON. The file appears whole or not at all."""
    street = archived.street
    header = ArchiveHeader(FORMAT, tuple(map(reference, street.maps)), street.config, archived.seed, about)
    arrays = {"points": archived.points, "present": archived.present, "keys": archived.keys.astype(np.int64)}
    text = json.dumps(asdict(header), sort_keys=True, allow_nan=False)
    write_whole(path, safetensors.numpy.save(arrays, {HEADER: text}))


def read_archive(path: str | Path) -> Archived:
    """Return the scenarios of a file, or of the folder of a search.

    Raises ArchiveError if it can't be used, and MapError if this jaxwalk lacks one of its maps.
    """
    file = archive_path(path)
    text, arrays = read_tensors(file, HEADER, "file of scenarios, as `jaxwalk search` and `jaxwalk live` write them")
    header = _header(file, text)
    missing = [name for name in ("points", "present", "keys") if name not in arrays]
    if missing:
        raise ArchiveError(f"{file}: has no array {', '.join(missing)}; {ADVICE}")
    if arrays["points"].ndim != 2 or not 1 <= len(arrays["points"]) <= MOST:
        raise ArchiveError(f"{file}: must hold 1 to {MOST:,} scenarios; {ADVICE}")
    if arrays["present"].dtype != bool or arrays["keys"].dtype != np.int64:
        raise ArchiveError(f"{file}: present must be true or false, and keys 64-bit integers; {ADVICE}")
    texts = [text_of(found) for found in header.maps]
    try:
        street = Street.create(texts, header.sim)
        return Archived(street, arrays["points"], arrays["present"], header.seed, arrays["keys"])
    except ValueError as error:
        if type(error).__module__.startswith("jaxwalk"):
            raise
        raise ArchiveError(f"{file}: {error}; {ADVICE}") from error


def archive_bytes(path: str | Path) -> bytes:
    """Return the bytes of a file of scenarios, or of the folder of a search. Raise ArchiveError if there is none."""
    return archive_path(path).read_bytes()


def archive_path(path: str | Path) -> Path:
    """Return the file of scenarios that a path means: itself, or that in the folder of a search.

    Raises ArchiveError if there is none.
    """
    path = Path(path)
    if path.is_dir() and not (path / SCENARIOS).is_file():
        raise ArchiveError(
            f"{path}: has no {SCENARIOS}; if it is the folder of a search, this found no failure or isn't finished"
        )
    file = path / SCENARIOS if path.is_dir() else path
    if not file.is_file():
        raise ArchiveError(f"{file}: no such file; check the name")
    return file


def read_tensors(path: Path, entry: str, what: str) -> tuple[str, dict[str, np.ndarray]]:
    """Return an entry of a safetensors file's header, and all its arrays. Raise ArchiveError if it can't be used.

    ``what`` says in a message what a file with that entry is.
    """
    if not path.is_file():
        raise ArchiveError(f"{path}: no such file; check the name")
    try:
        with safetensors.safe_open(str(path), framework="numpy") as file:
            text = (file.metadata() or {}).get(entry)
            names = file.keys()
            arrays = {name: file.get_tensor(name) for name in names}
    except (safetensors.SafetensorError, OSError, TypeError, AttributeError) as error:  # the last two: unknown dtypes
        raise ArchiveError(f"{path}: damaged or no safetensors file ({error}); {ADVICE}") from error
    if text is None:
        raise ArchiveError(f"{path}: a safetensors file, but no {what}; check the name")
    return text, arrays


def _header(path: Path, text: str) -> ArchiveHeader:
    """Return the checked header. The format comes first, because another format may have other fields."""
    try:
        content = pydantic.TypeAdapter(dict[str, Any]).validate_json(text)
        version = content.get("format")
        if version != FORMAT:
            raise ArchiveError(
                f"{path}: has format {version!r:.40}, this jaxwalk reads {FORMAT}; use a version that reads it"
            )
        header = pydantic.TypeAdapter(ArchiveHeader).validate_json(text)
    except (pydantic.ValidationError, RecursionError) as error:
        first = error.errors(include_url=False)[0] if isinstance(error, pydantic.ValidationError) else None
        where = ".".join(str(part) for part in first["loc"])[:80] if first else "lists inside lists"
        said = first["msg"][:200] if first else "too deep"
        raise ArchiveError(f"{path}: its header is wrong ({where}: {said}); {ADVICE}") from error
    if not header.maps:
        raise ArchiveError(f"{path}: its header names no map; {ADVICE}")
    return header
