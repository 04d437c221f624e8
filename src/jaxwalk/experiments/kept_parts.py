"""The finished parts of one evaluation in a folder, while others are still to be played."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

from jaxwalk.evaluation import BATCH
from jaxwalk.evaluation.parts import PART, Part, PartDocument, PartError, StoredPart, difference, read_part
from jaxwalk.evaluation.reading import DocumentError
from jaxwalk.experiments.evaluating import Evaluation
from jaxwalk.experiments.in_parts import planned_part
from jaxwalk.wording import counted
from jaxwalk.writing import remove_unfinished, together, write_whole

FEWEST, USUAL, MOST = 16, 8_192, 131_072
"""Usual least number of parts; usual number of episodes of all cells that a part plays, and the most: its files are
sent as a whole, and take up to some 0.5 kB an episode."""


def number_of_parts(work: Evaluation, asked: int | None, *, batch: int = BATCH) -> int:
    """Return into how many parts to divide an evaluation: as asked for, or about `USUAL` episodes in each.

    It doesn't depend on the machine, so that a command goes on elsewhere. Raise PartError if there are fewer blocks,
    or if a part would play more than `MOST` episodes in all its cells.
    """
    blocks = -(-work.episodes // batch)
    cells = len(work.streets) * len(work.drivers) * len(work.populations)
    if asked is None:
        return min(blocks, max(FEWEST, -(-work.episodes * cells // USUAL)))
    if asked > blocks:
        divided = f"{work.episodes:,} episodes are {counted(blocks, 'block')} of {batch}"
        raise PartError(f"--parts {asked}: {divided}, so there are at most {blocks:,} parts; take a smaller N")
    least = min(blocks, -(-work.episodes * cells // MOST))
    if asked < least:
        most = f"a part plays at most {MOST:,} episodes in all its cells"
        raise PartError(f"--parts {asked}: {most}; take at least {least:,}")
    return asked


@dataclass(frozen=True)
class KeptParts:
    """The parts of an evaluation: each one that is finished has a folder, named by its number."""

    folder: Path
    planned: PartDocument
    """What each part will say about itself, but for its number."""

    @staticmethod
    def of(work: Evaluation, folder: Path, parts: int, *, batch: int = BATCH) -> KeptParts:
        """Return the parts of an evaluation in a folder, which may have some already.

        Raise PartError or DocumentError, which name the part, if one is damaged or of another evaluation.
        """
        kept = KeptParts(folder, planned_part(work, Part(1, parts), batch=batch))
        for part in kept.finished():
            kept._check(part)
        return kept

    @property
    def names(self) -> list[str]:
        """The names of all parts, such as ``3/16``."""
        return [Part(number, self.planned.part.of).name for number in range(1, self.planned.part.of + 1)]

    def finished(self) -> list[StoredPart]:
        """Return the parts that are finished, in their order. Raises as `read_part` does."""
        return [read_part(folder) for name in self.names if ((folder := self._place(name)) / PART).is_file()]

    def missing(self) -> list[str]:
        """Return the names of the parts that aren't finished."""
        return [name for name in self.names if not (self._place(name) / PART).is_file()]

    def episodes(self, name: str) -> int:
        """Return the number of scenarios of a part."""
        return len(replace(self.planned, part=Part.parse(name)).span)

    def keep(self, name: str, files: dict[str, bytes]) -> None:
        """Write the files of a part that was played, all or none. Raises as `of` does for one that isn't wanted."""
        place = self._place(name)
        place.mkdir(parents=True, exist_ok=True)
        remove_unfinished(place)
        with together():
            for file in sorted(files, key=lambda file: file == PART):  # last, as it says that the part is there
                write_whole(place / file, files[file])
        try:
            self._check(read_part(place))
        except (PartError, DocumentError):
            (place / PART).unlink()  # first, so that a kill leaves no half part
            shutil.rmtree(place)  # it would stop the same command from going on with the others
            raise

    def remove(self) -> None:
        """Remove all parts, and their folder if nothing else is in it.

        None counts as finished any more before the first table goes: a kill meanwhile leaves no half one.
        """
        for name in self.names:
            (self._place(name) / PART).unlink(missing_ok=True)
        for name in self.names:
            shutil.rmtree(self._place(name), ignore_errors=True)
        if not any(self.folder.iterdir()):
            self.folder.rmdir()

    def _place(self, name: str) -> Path:
        return self.folder / name.partition("/")[0]

    def _check(self, part: StoredPart) -> None:
        """Raise PartError unless a part is of this evaluation, in the folder of its number."""
        found = difference(self.planned, part.document)
        if found is None and part.folder.name != str(part.document.part.number):
            found = f"it is part {part.document.part.name}"
        if found is not None:
            advice = f"name another --out, or remove {self.folder}"
            raise PartError(f"{part.folder}: isn't what this evaluation needs there: {found}; {advice}")
