"""Parts of an evaluation: which scenarios each has, what it says about itself, and whether parts make a whole.

A part is a folder with the files of `jaxwalk.evaluation.row_files` and part.json, a `PartDocument`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

from jaxwalk.evaluation.batches import BATCH
from jaxwalk.evaluation.document_parts import EvaluationOptions, PolicyOrigin, StreetOrigin
from jaxwalk.evaluation.reading import DocumentError, Origin, as_document
from jaxwalk.evaluation.stored_rows import ADVICE, StoredCell
from jaxwalk.metrics.statistics import CHUNK
from jaxwalk.provenance import Provenance
from jaxwalk.wording import counted, first_of

PART = "part.json"
"""Name of the file that says what a part is. It is written last."""
FORMAT = 2
"""Version of the files of a part."""


class PartError(ValueError):
    """Parts can't be made or put together. The message says what is wrong and what to do, in one line."""


@dataclass(frozen=True)
class Part:
    """One of several parts, into which the scenarios of an evaluation are divided."""

    number: int
    """Which part, from 1."""
    of: int
    """Number of parts."""

    @staticmethod
    def parse(text: str) -> Part:
        """Return the part that a text such as ``3/16`` names. Raise PartError for another text."""
        found = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
        part = Part(int(found[1]), int(found[2])) if found else Part(0, 0)
        if not 1 <= part.number <= part.of:
            raise PartError(f"--part {text}: must be K/N with K from 1 to N, such as 3/16")
        return part

    def span(self, episodes: int, batch: int = BATCH) -> range:
        """Return the numbers of the part's scenarios.

        Parts have whole blocks of ``batch``, so that each batch is the one of an evaluation of all. Raise PartError if
        there are fewer blocks than parts.
        """
        blocks = -(-episodes // batch)
        if self.of > blocks:
            divided = f"{counted(episodes, 'episode')} are {counted(blocks, 'block')} of {batch}"
            raise PartError(f"--part {self.name}: {divided}, so there are at most {blocks:,} parts; take a smaller N")
        first, stop = (blocks * number // self.of * batch for number in (self.number - 1, self.number))
        return range(first, min(stop, episodes))

    @property
    def name(self) -> str:
        """The part as ``3/16``."""
        return f"{self.number}/{self.of}"


@dataclass(frozen=True)
class PartCell:
    """What a part says about one of its cells; the fields are those of `jaxwalk.evaluation.Cell`."""

    driver: str
    pedestrians: str
    driver_mode: str
    pedestrian_mode: str
    jaywalk_multiplier: float
    driver_observes: str
    pedestrian_observes: str
    driver_seconds: float
    """Time that a driver outside JAX took for all its steps [s]; 0 for a driver in JAX."""
    driver_steps: int
    """Number of those steps, each for a batch."""
    sha256: str
    """The digest of its rows (`jaxwalk.evaluation.row_files.RowDigest`)."""

    def about(self) -> dict[str, Any]:
        """Return the fields of a `Cell` that are the same in every part."""
        own = ("driver_seconds", "driver_steps", "sha256")
        return {name: value for name, value in vars(self).items() if name not in own}


@dataclass(frozen=True)
class PartDocument:
    """What a part says about itself."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    format: int
    part: Part
    scenarios_hash: str
    """The hash of the part's own scenarios."""
    seed: int
    """Seed of all scenarios."""
    episodes: int
    """Number of scenarios of all parts together."""
    batch: int
    """Episodes in a block: a part has whole ones."""
    dt: float
    """Duration of a step [s]."""
    street: StreetOrigin
    drivers: tuple[PolicyOrigin, ...]
    populations: tuple[PolicyOrigin, ...]
    options: EvaluationOptions
    cells: tuple[PartCell, ...]
    made: Provenance

    @property
    def span(self) -> range:
        """The numbers of the part's scenarios. Raise PartError if it can't be."""
        return self.part.span(self.episodes, self.batch)

    def to_json(self) -> str:
        """Return the document as text."""
        return json.dumps({**asdict(self), "street": self.street.as_dict()}, indent=2, allow_nan=False) + "\n"


@dataclass(frozen=True)
class StoredPart:
    """A part in its folder."""

    folder: Path
    document: PartDocument

    def cell(self, number: int) -> StoredCell:
        """Return where the rows of a cell are."""
        sizes = tuple(map(len, pieces_of(self.document.span)))
        return StoredCell(self.folder, number, sizes, self.document.dt)


def pieces_of(span: range) -> list[range]:
    """Return the pieces in which rows of scenarios are kept: they end where a chunk of all scenarios does."""
    ends = [*range((span.start // CHUNK + 1) * CHUNK, span.stop, CHUNK), span.stop]
    return [range(first, stop) for first, stop in pairwise([span.start, *ends])]


def read_parts(folders: Sequence[Path]) -> list[StoredPart]:
    """Return the parts in folders. Raise PartError that names all folders without one, or DocumentError."""
    _check_there(folders)
    return [read_part(folder) for folder in folders]


def read_part(folder: Path) -> StoredPart:
    """Return the part in a folder. Raise PartError or DocumentError, a message that names it, if there is none."""
    _check_there([folder])
    path = folder / PART
    try:
        content = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise DocumentError(f"{path}: is no JSON document ({error}); {ADVICE}") from error
    found = content.get("format") if isinstance(content, dict) else None
    if found != FORMAT:
        raise PartError(f"{path}: is of format {found!r:.40}, this jaxwalk reads {FORMAT}; {ADVICE}")
    document = as_document(PartDocument, content, Origin(path, ADVICE))
    _check_whole(path, document)
    return StoredPart(folder, document)


def _check_there(folders: Sequence[Path]) -> None:
    """Raise PartError that names the folders without a finished part."""
    empty = [str(folder) for folder in folders if not (folder / PART).is_file()]
    if len(empty) == 1:
        advice = f"{PART}, so no finished part is in it; evaluate that part, or name its folder"
        raise PartError(f"{empty[0]}: has no {advice}")
    if empty:
        advice = f"{PART}, so no finished parts are in them; evaluate those parts, or name their folders"
        raise PartError(f"{first_of(empty, 'folder')}: have no {advice}")


def _check_whole(path: Path, document: PartDocument) -> None:
    """Raise DocumentError if numbers in a part's document can't be together."""
    part, cells = document.part, len(document.cells)
    wanted = len(document.options.jaywalk_multipliers) * len(document.drivers) * len(document.populations)
    batches = -(-document.episodes // max(document.batch, 1))
    if not 1 <= part.number <= part.of <= batches or document.dt <= 0 or document.batch < 1 or CHUNK % document.batch:
        raise DocumentError(f"{path}: damaged (part {part.name} of {document.episodes:,} episodes); {ADVICE}")
    if cells != wanted or not cells:
        raise DocumentError(f"{path}: damaged ({cells} cells, not {wanted}); {ADVICE}")


def complete(parts: Sequence[StoredPart]) -> tuple[list[StoredPart], list[str]]:
    """Return the parts of one evaluation in the order of their scenarios, without duplicates, and lines about them.

    Raises:
        PartError: they are parts of different evaluations, one is missing, or two of one number differ.
    """
    chosen: dict[int, StoredPart] = {}
    said = []
    for part in parts:
        _check_alike(parts[0], part)
        number = part.document.part.number
        before = chosen.setdefault(number, part)
        if before is not part:
            _check_equal(before, part)
            said.append(f"{part.folder}: part {part.document.part.name} again, with the same rows; left out")
    of = parts[0].document.part.of
    missing = [f"{number}/{of}" for number in range(1, of + 1) if number not in chosen]
    if missing:
        which = first_of(missing, "part") + (" is" if len(missing) == 1 else " are")
        raise PartError(f"{which} missing; evaluate with --part {missing[0]}, or name its folder too")
    hardware = sorted({part.document.made.hardware for part in chosen.values()})
    if len(hardware) > 1:
        said.append(
            f"the parts were played on {' and '.join(hardware)}: last digits may differ from those of one machine"
        )
    return [chosen[number] for number in sorted(chosen)], said


def _check_equal(a: StoredPart, b: StoredPart) -> None:
    """Raise PartError unless two parts with the same number have the same rows."""
    if [cell.sha256 for cell in a.document.cells] != [cell.sha256 for cell in b.document.cells]:
        which = f"both are part {a.document.part.name}"
        raise PartError(f"{a.folder} and {b.folder}: {which}, but their rows differ; leave out one of them")


def _check_alike(first: StoredPart, other: StoredPart) -> None:
    """Raise PartError unless two parts are of the same evaluation, made by the same versions."""
    found = difference(first.document, other.document)
    if found is not None:
        raise PartError(f"{other.folder}: isn't of the same evaluation as {first.folder}: {found}; leave it out")


def difference(wanted: PartDocument, found: PartDocument) -> str | None:
    """Return how a part's evaluation differs from a wanted one, as ``its seed is 8, not 7``; None if it doesn't."""
    for (what, a), (_, b) in zip(_settings(wanted), _settings(found), strict=True):
        if a != b:
            return f"{what} {b!s:.80}, not {a!s:.80}"
    return None


def _settings(document: PartDocument) -> list[tuple[str, Any]]:
    """Return what the parts of one evaluation have in common, each with its name."""
    origins = [("its driver is", x.in_words()) for x in document.drivers]
    origins += [("its population is", x.in_words()) for x in document.populations]
    made = [("it was made by commit", document.made.commit), ("its versions are", document.made.versions)]
    numbers = [(f"its {name} is", getattr(document, name)) for name in ("seed", "episodes", "batch", "dt")]
    return [
        ("its drivers are", [x.name for x in document.drivers]),
        ("its populations are", [x.name for x in document.populations]),
        *origins,
        *numbers,
        ("its number of parts is", document.part.of),
        ("its maps are", [(x.name, x.hash) for x in document.street.maps]),
        ("its world is", document.street.sim),
        ("its options are", document.options),
        *made,
        ("its cells are", [cell.about() for cell in document.cells]),
    ]
