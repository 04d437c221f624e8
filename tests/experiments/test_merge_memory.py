"""A merge keeps a chunk of episodes in memory, whatever their number (`-s` prints the figures)."""

import subprocess
import sys
from pathlib import Path

import pytest

from jaxwalk import Drawn, Street
from jaxwalk.evaluation import BATCH
from jaxwalk.evaluation.batches import evaluate_batches
from jaxwalk.evaluation.row_files import RowWriter
from jaxwalk.metrics import Rows
from jaxwalk.metrics.statistics import CHUNK
from jaxwalk.policies import AlwaysGo, RouteFollower

pytestmark = pytest.mark.long
CHUNKS = (4, 24)
"""Numbers of chunks. The most memory still grows by a few MB up to the fourth."""
GROWTH = 0.05
"""Most growth [kB] with an episode, whose rows take 1.4 kB."""


def test_memory_of_a_merge_does_not_grow_with_episodes(tmp_path):
    street = Street.create()
    policies = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
    some = list(evaluate_batches(street, policies, Drawn(street, 0, 2 * BATCH), batch=BATCH))
    rows = Rows.join(some * (CHUNK // (2 * BATCH)))
    peaks = []
    for chunks in CHUNKS:
        with RowWriter(tmp_path) as writer:
            for _ in range(chunks):
                writer.write(0, rows)
        command = [sys.executable, Path(__file__).with_name("merge_memory.py"), tmp_path, str(chunks * CHUNK)]
        peaks.append(float(subprocess.run(command, capture_output=True, text=True, check=True).stdout))
        print(f"{chunks * CHUNK:,} episodes: {peaks[-1]:.0f} MB")
    assert (peaks[1] - peaks[0]) * 1024 < GROWTH * (CHUNKS[1] - CHUNKS[0]) * CHUNK
