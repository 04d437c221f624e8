"""Each part in a process of its own: JAX reads flags once, and memory's peak is a process's."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import asdict
from typing import Any

from jaxwalk.experiments.benchmark.settings import Settings
from jaxwalk.experiments.provenance import cores

SHARED_OUT = {"JAX_NUM_CPU_DEVICES": str(cores())}
"""A device for each core: the environments are shared out among them. It changes nothing on an accelerator."""
ENVIRONMENT = {"env": SHARED_OUT, "pedestrians": SHARED_OUT}
"""Variables that a part's process gets; all others are this process's."""


class BenchmarkError(ValueError):
    """A part that could not be measured; one line says which."""


def measure_apart(part: str, settings: Settings) -> Any:
    """What a part found; how it goes is told on standard error."""
    command = [sys.executable, "-m", __package__ or "", part, json.dumps(asdict(settings))]
    done = subprocess.run(
        command, env=os.environ | variables(part), stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, check=False
    )
    if done.returncode:
        raise BenchmarkError(f"the part {part} could not be measured (exit code {done.returncode}); see above")
    try:
        return json.loads(done.stdout.splitlines()[-1])  # a library may have printed something before
    except (IndexError, ValueError) as error:
        raise BenchmarkError(f"the part {part} gave no document; see above") from error


def variables(part: str) -> dict[str, str]:
    """What to set for a part, unless somebody chose a number of devices already."""
    chosen = "host_platform_device_count" in os.environ.get("XLA_FLAGS", "") or "JAX_NUM_CPU_DEVICES" in os.environ
    return {} if chosen else ENVIRONMENT.get(part, {})


def tell(text: str) -> None:
    """A line on standard error."""
    print(f"    {text}", file=sys.stderr, flush=True)
