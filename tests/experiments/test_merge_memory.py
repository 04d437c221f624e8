"""A merge keeps a few columns in memory, whatever the number of episodes (`-s` prints the figures)."""

import subprocess
import sys
from pathlib import Path

import pytest

from jaxwalk import Drawn, Street
from jaxwalk.evaluation import BATCH
from jaxwalk.evaluation.batches import evaluate_batches
from jaxwalk.evaluation.stored_rows import RowWriter
from jaxwalk.policies import AlwaysGo, RouteFollower

pytestmark = pytest.mark.long
SIZES = (32_768, 131_072)
"""Numbers of episodes; both are several chunks."""
GROWTH = 0.5
"""Most growth [kB] with an episode, whose rows take 1.4 kB: a million episodes then need 0.5 GB more."""


def test_a_merge_of_a_million_episodes_fits_into_memory(tmp_path):
    street = Street.create()
    policies = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
    batches = list(evaluate_batches(street, policies, Drawn(street, 0, 2 * BATCH), batch=BATCH))
    peaks = []
    for episodes in SIZES:
        with RowWriter(tmp_path) as writer:
            for number in range(episodes // BATCH):
                writer.write(0, batches[number % len(batches)])
        command = [sys.executable, Path(__file__).with_name("merge_memory.py"), tmp_path, str(episodes // BATCH)]
        peaks.append(float(subprocess.run(command, capture_output=True, text=True, check=True).stdout))
        print(f"{episodes:,} episodes: {peaks[-1]:.0f} MB")
    assert (peaks[1] - peaks[0]) * 1024 < GROWTH * (SIZES[1] - SIZES[0])
