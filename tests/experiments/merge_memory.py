"""Print the most memory [MB] of a process that sums up stored rows, as a merge does: FOLDER, number of episodes."""

import sys
from pathlib import Path

from jaxwalk.evaluation.parts import pieces_of
from jaxwalk.evaluation.stored_rows import StoredCell, stored_rows
from jaxwalk.metrics import summarise

sizes = tuple(map(len, pieces_of(range(int(sys.argv[2])))))
summarise(stored_rows([StoredCell(Path(sys.argv[1]), 0, sizes, dt=0.1)]))
lines = dict(line.split(":") for line in Path("/proc/self/status").read_text().splitlines())
print(int(lines["VmHWM"].split()[0]) / 1024)  # getrusage would count what the process was forked from
