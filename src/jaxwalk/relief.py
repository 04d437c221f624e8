"""Keeps a long study small: every training and driver brings programs of its own, and measuring frees much memory."""

from __future__ import annotations

import ctypes
import gc
import mmap
import sys
from pathlib import Path

import jax

MOST_MAPPINGS = 20_000
"""With more memory mappings than this, the process forgets its programs. Linux allows it 65,530 (``vm.max_map_count``);
a cell with replayed collisions takes 2,500; and when there are none left, compiling ends the process."""
MOST_RESIDENT = 1_500_000_000
"""A process that takes more memory than this [bytes] gives back what is free. That slows what it does next: an
evaluation of 1,024 scenarios by a tenth, since each page has to be asked for again."""
MAPPINGS, PAGES = Path("/proc/self/maps"), Path("/proc/self/statm")
"""A line for each memory mapping; and the number of pages, those in memory as the second one. Only Linux has them."""


def relieve() -> None:
    """Forget compiled programs if they take too many mappings; give freed memory back if the process has grown large.

    Programs that are needed again are then compiled again.
    """
    if mappings() > MOST_MAPPINGS:
        jax.clear_caches()
        gc.collect()
    if resident() > MOST_RESIDENT:
        give_back()


def give_back() -> None:
    """Give freed memory back to the system, where the C library keeps it."""
    if sys.platform != "linux":
        return
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # only glibc has it
    if trim is not None:
        trim(0)


def mappings() -> int:
    """Return how many memory mappings this process has; 0 where nobody says."""
    return MAPPINGS.read_bytes().count(b"\n") if MAPPINGS.exists() else 0


def resident() -> int:
    """Return how much memory this process takes [bytes]; 0 where nobody says."""
    return int(PAGES.read_text().split()[1]) * mmap.PAGESIZE if PAGES.exists() else 0
