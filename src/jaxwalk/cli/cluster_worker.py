"""What a worker of a cluster does: it plays parts of an evaluation, each into files that it returns.

A worker imports this module first. So nothing here imports JAX before its machine is prepared for it.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from jaxwalk.cli.jax_start import prepare_machine, start_jax
from jaxwalk.cli.options import Evaluate

if TYPE_CHECKING:
    from jaxwalk.experiments.evaluating import Evaluation


@dataclass(frozen=True)
class PlayPart:
    """Plays parts of the evaluation that options ask for."""

    options: Evaluate
    folder: str
    """Working folder of the command: where its names of files begin."""
    environment: tuple[tuple[str, str], ...]
    """Environment variables that JAX is to have, each with its value."""
    scratch: str | None
    """Where temporary folders are made; None for the machine's usual place."""

    def __call__(self, part: str) -> dict[str, bytes]:
        """Return the files of the part of a name such as ``3/16``.

        Raises what `evaluate_part` raises, and what loading of policies does.
        """
        if Path(self.folder).is_dir():  # other machines need it only for names of files
            os.chdir(self.folder)
        os.environ.update(self.environment)
        start_jax(prepare_machine())
        from jaxwalk.evaluation.parts import Part
        from jaxwalk.experiments.in_parts import evaluate_part
        from jaxwalk.relief import give_back

        with TemporaryDirectory(prefix="jaxwalk-", dir=self.scratch) as folder:
            evaluate_part(_loaded(self.options), Part.parse(part), Path(folder), _tell_nobody)
            files = {path.name: path.read_bytes() for path in Path(folder).iterdir()}
        give_back()  # else a worker grows from part to part
        return files


@lru_cache(1)
def _loaded(options: Evaluate) -> Evaluation:
    """Return what the options ask for, with all policies loaded: once for all parts that a worker plays."""
    from jaxwalk.cli.evaluation_asked import work_of

    return work_of(options)


def _tell_nobody(what: str, done: int, total: int) -> None:
    """The command tells of whole parts."""
