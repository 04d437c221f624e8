"""Print the most memory [MB] of a process that sums up stored rows, as a merge does: FOLDER, number of batches."""

import resource
import sys
from itertools import islice
from pathlib import Path

from jaxwalk.evaluation import BATCH
from jaxwalk.evaluation.stored_rows import StoredCell, stored_rows
from jaxwalk.metrics import Rows, summarise
from jaxwalk.metrics.statistics import CHUNK

cell = StoredCell(Path(sys.argv[1]), 0, int(sys.argv[2]), dt=0.1)
each = cell.rows()
chunks = iter(lambda: list(islice(each, CHUNK // BATCH)), [])
summarise(stored_rows([cell]), chunks=map(Rows.join, chunks))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
