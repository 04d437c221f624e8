"""Begin a training where another one is, with other numbers: the step of population-based training."""

from __future__ import annotations

from jaxwalk.learning import checkpoint
from jaxwalk.runs.folder import Run, as_json


def begin_at(run: Run, parent: Run, updates: int) -> None:
    """Copy a checkpoint of another run into a run that has none yet, so that it is resumed from there.

    Networks, optimisers and episodes in progress are the parent's. So is the number of updates made, which says where
    in its plan a training is. Maps and kept scenarios must be those of the parent; resuming checks that.

    Raises:
        DamagedError: the parent has no such checkpoint, or it can't be read.
        OSError: the copy can't be written.
    """
    if checkpoint.latest(run.checkpoints) is not None:
        return
    changes = {"configuration": as_json(run.experiment)}
    checkpoint.copy(parent.checkpoints, run.checkpoints, updates=updates, changes=changes)
