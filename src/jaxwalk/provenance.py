"""The origin of a result: commit, hardware, versions."""

from __future__ import annotations

import os
import platform
import subprocess
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import ClassVar

VERSIONS = ("jaxwalk", "jax", "jaxlib", "numpy", "equinox", "optax")
"""Packages whose versions affect results."""


@dataclass(frozen=True)
class Provenance:
    """The origin of results."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    commit: str | None
    """Commit of the source code; None outside a checkout."""
    hardware: str
    versions: dict[str, str]
    """Versions of Python and of the main packages."""


def provenance() -> Provenance:
    """Return commit (None outside a checkout), hardware and versions."""
    return Provenance(commit=commit(), hardware=hardware(), versions=versions())


def versions() -> dict[str, str]:
    """Return Python's version and that of every installed package in VERSIONS."""
    found = {"python": platform.python_version()}
    for name in VERSIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


@cache
def commit() -> str | None:
    """Return the git commit of the checkout that contains this code, with ``+`` if changed; None if there is none.

    It is asked for once: a process goes on with the code that it began with, whatever is committed meanwhile.
    """
    here = Path(__file__).resolve().parent
    known = _git(here, "ls-files", "--error-unmatch", __file__)  # else it is a wheel installed inside another checkout
    found = _git(here, "rev-parse", "--short=12", "HEAD") if known else None
    if not found:
        return None
    return found + ("+" if _git(here, "status", "--porcelain", "--untracked-files=no") else "")


def hardware() -> str:
    """Return a description of the computing hardware."""
    import jax

    devices = jax.devices()
    kind = devices[0].device_kind
    if devices[0].platform == "cpu":
        return f"{processor()}, {cores()} cores"
    return f"{len(devices)} x {kind}"


@cache
def cores() -> int:
    """Return the number of cores that this process may use, or might when this was first asked."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def processor() -> str:
    """Return the processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        done = subprocess.run(["git", *arguments], cwd=folder, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None
