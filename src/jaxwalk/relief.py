"""Keeps a long study small: every training and driver brings programs of its own, and measuring frees much memory."""

from __future__ import annotations

import ctypes
import gc
import sys
from pathlib import Path

import jax

MOST_MAPPINGS = 20_000
"""With more memory mappings than this, the process forgets its programs. Linux allows it 65,530 (``vm.max_map_count``);
a cell with replayed collisions takes 2,500; and when there are none left, compiling ends the process."""
MAPPINGS = Path("/proc/self/maps")
"""A line for each memory mapping; only Linux has it."""


def relieve() -> None:
    """Give freed memory back to the system, and forget compiled programs if they take too many mappings.

    Programs that are needed again are then compiled again.
    """
    if mappings() > MOST_MAPPINGS:
        jax.clear_caches()
        gc.collect()
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # only glibc has it
        if trim is not None:
            trim(0)


def mappings() -> int:
    """Return how many memory mappings this process has; 0 where nobody says."""
    return MAPPINGS.read_bytes().count(b"\n") if MAPPINGS.exists() else 0
