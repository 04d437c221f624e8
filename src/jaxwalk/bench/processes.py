"""Runs each part in a process of its own: JAX reads flags once, and peak memory is measured for a whole process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from jaxwalk.bench.benchmark_settings import Settings


class BenchmarkError(ValueError):
    """A part could not be measured. The message names it, in one line."""


def measure_apart(part: str, settings: Settings, environment: Mapping[str, str] | None = None) -> Any:
    """Return what a part measured in a process of its own; its progress goes to standard error.

    ``environment`` has variables that the process gets besides those of this one.
    """
    command = [sys.executable, "-m", __package__ or "", part, json.dumps(asdict(settings))]
    variables = os.environ | dict(environment or {})
    done = subprocess.run(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, env=variables, check=False)
    if done.returncode:
        raise BenchmarkError(f"the part {part} could not be measured (exit code {done.returncode}); see above")
    try:
        return json.loads(done.stdout.splitlines()[-1])  # a library may have printed something before the document
    except (IndexError, ValueError) as error:
        raise BenchmarkError(f"the part {part} gave no document; see above") from error


def tell(text: str) -> None:
    """Print a line on standard error."""
    print(f"    {text}", file=sys.stderr, flush=True)
