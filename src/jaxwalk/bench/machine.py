"""The machine: its hardware, and the most memory that this process has used."""

from __future__ import annotations

import os
import sys
from dataclasses import asdict
from typing import Any

import jax

from jaxwalk.bench.benchmark_settings import Settings
from jaxwalk.provenance import cores, processor, provenance


def describe(settings: Settings) -> dict[str, Any]:
    """Return hardware and provenance."""
    device = jax.devices()[0]
    limit = (device.memory_stats() or {}).get("bytes_limit") if accelerated() else None
    hardware = {
        "processor": processor(),
        "cores": cores(),
        "memory_bytes": _memory(),
        "accelerator": device.device_kind if accelerated() else None,
        "accelerators": len(jax.devices()) if accelerated() else 0,
        "accelerator_memory_bytes": limit,
        "platform": device.platform,
        "devices": len(jax.devices()),
        "xla_flags": os.environ.get("XLA_FLAGS", ""),
    }
    return {"hardware": hardware, "provenance": asdict(provenance())}


def accelerated() -> bool:
    """Return whether there is an accelerator."""
    return jax.devices()[0].platform != "cpu"


def peak_memory() -> int | None:
    """Return the most memory that this process has held so far [B], on the accelerator if there is one."""
    if accelerated():
        return (jax.devices()[0].memory_stats() or {}).get("peak_bytes_in_use")
    try:
        import resource
    except ImportError:  # Windows
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def _memory() -> int | None:
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return None
