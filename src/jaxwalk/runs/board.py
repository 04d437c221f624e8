"""Writes metrics for TensorBoard."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from jaxwalk.writing import naming


class Board:
    """A file of events, in the order written. A repeated update hides the one of an earlier session.

    Not tensorboardX's `SummaryWriter`: that writes in a thread, which dies when the disk is full; then its queue fills
    and training hangs.
    """

    def __init__(self, folder: Path, *, first: int) -> None:
        """Create a new file in the folder; ``first`` is the first update that will be written."""
        from tensorboardX.event_file_writer import EventsWriter

        self._folder, self._types = folder, import_module("tensorboardX.proto.event_pb2")
        start = self._types.SessionLog(status=self._types.SessionLog.START)
        with naming(folder):
            # tensorboardX names files by the second: a session begun within the same second would overwrite it
            self._file: Any = EventsWriter(str(folder / "events"), f".{os.getpid()}.{time.time_ns()}")
            self._file.write_event(self._types.Event(step=first, session_log=start))
            self._file.flush()

    def write(self, line: Mapping[str, int | float]) -> None:
        """Write the metrics of one update, ``update`` among them."""
        event = self._types.Event(wall_time=time.time(), step=line["update"])
        for name, value in line.items():
            if name != "update":
                event.summary.value.add(tag=name, simple_value=value)
        with naming(self._folder):
            self._file.write_event(event)
            self._file.flush()

    def close(self) -> None:
        """Write what is still buffered, and close the file."""
        with naming(self._folder):
            self._file.close()
