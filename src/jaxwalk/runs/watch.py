"""A page in the run folder that shows the progress of a training: ``watch.html``, opened from disk.

After updates, ``watch.js`` is written whole: a script that only hands over the numbers. The page loads it every few
seconds, so no server is needed. The numbers are those of ``metrics.jsonl``: the accelerator computes nothing more.
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.runs.folder import Run
from jaxwalk.runs.progress import Pace
from jaxwalk.writing import write_whole

PAGE, NUMBERS = "watch.html", "watch.js"
"""File names inside a run folder."""
EVERY = 2.0
"""Shortest time between two writes of the numbers [s]."""
POINTS = 150
"""Largest number of points of a curve; each is the mean of equally many updates."""
RECENT = 10
"""Number of last updates over whose episodes the recent endings are shown."""
ENDINGS = ("goal_rate", "collision_rate", "timeout_rate")
"""Curves in which an update weighs as much as the number of episodes that ended in it."""
LEARNING = ("learning_rate", *(f"{role}/{name}" for role in ("driver", "pedestrian") for name in (
    "entropy", "kl", "clip_fraction", "policy_loss", "critic_loss", "explained_variance",
)))  # fmt: skip
CURVES = (*ENDINGS, "reward/driver", "reward/pedestrian", *LEARNING)
"""Metrics that the page shows."""


class WatchPage:
    """The page of one training. Use it in a ``with``: if an exception leaves it, the page shows a failed training."""

    def __init__(self, run: Run, name: str, pace: Pace, earlier: Sequence[Mapping[str, Any]]) -> None:
        """Continue after the metrics of earlier sessions; ``name`` is the name of the training."""
        self.path = run.path / PAGE
        self._numbers, self._name, self._pace = run.path / NUMBERS, name, pace
        self._lines, self._written = list(earlier), 0.0

    def __enter__(self) -> WatchPage:
        self._write("starting")
        page = resources.files("jaxwalk.runs").joinpath(PAGE).read_text(encoding="utf-8")
        write_whole(self.path, page)
        return self

    def __exit__(self, failed: type[BaseException] | None, *_: object) -> None:
        done = self._pace.made >= self._pace.planned
        self._write("failed" if failed else "finished" if done else "stopped")

    def show(self, line: Mapping[str, Any]) -> None:
        """Add one more update. Its pace must already be recorded."""
        self._lines.append(line)
        if time.monotonic() - self._written >= EVERY:
            self._write("training")

    def _write(self, status: str) -> None:
        pace, self._written = self._pace, time.monotonic()
        numbers = {
            "name": self._name,
            "folder": str(self.path.parent),
            "status": status,
            "update": pace.made,
            "planned": pace.planned,
            "steps": pace.made * pace.steps_per_update,
            "rate": pace.rate,
            "left": pace.left,
            "seconds": self._lines[-1]["seconds"] if self._lines else 0.0,
            "written": time.time(),
            **curves(self._lines),
        }
        write_whole(self._numbers, f"show({json.dumps(numbers, allow_nan=False)});\n")


def there_is_one(folder: Path) -> bool:
    """Return whether an earlier session of the run made a page."""
    return (folder / PAGE).is_file()


def curves(lines: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return ``at``, the last update of each of up to `POINTS` stretches; ``curves``, their means by name; ``recent``,
    the endings in the last updates; and ``recent_updates``, how many these are.

    A mean is None if no number is known, such as for endings before the first episode ends.
    """
    if not lines:
        return {"at": [], "curves": {}, "recent": {}, "recent_updates": 0}
    begins = np.linspace(0, len(lines), min(len(lines), POINTS), endpoint=False).astype(int)
    last = [*(begins[1:] - 1), len(lines) - 1]
    names = [name for name in CURVES if name in lines[-1]]
    return {
        "at": [lines[i]["update"] for i in last],
        "curves": {name: _means(lines, name, begins) for name in names},
        "recent": {name: _means(lines[-RECENT:], name, np.array([0]))[0] for name in names if name in ENDINGS},
        "recent_updates": len(lines[-RECENT:]),
    }


def _means(lines: Sequence[Mapping[str, Any]], name: str, begins: np.ndarray) -> list[float | None]:
    """Return the mean of each stretch of lines, given where each begins; a line without the number has no weight."""
    counted = [line.get("episodes", 0.0) if name in ENDINGS else 1.0 for line in lines]
    weights = np.array([count if name in line else 0.0 for count, line in zip(counted, lines, strict=True)])
    values = np.array([line.get(name, 0.0) for line in lines])
    total, weight = (np.add.reduceat(x, begins) for x in (values * weights, weights))
    return [float(f"{t / w:.5g}") if w > 0 and np.isfinite(t) else None for t, w in zip(total, weight, strict=True)]
