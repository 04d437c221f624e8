"""The process of one part: ``python -m jaxwalk.bench PART SETTINGS`` prints a document on stdout."""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Any

from pydantic import TypeAdapter

from jaxwalk.bench.benchmark_settings import Settings

PROGRAMS = {
    "machine": ("machine", "describe"),
    "env": ("simulation", "over_environments"),
    "pedestrians": ("simulation", "over_pedestrians"),
    "streets": ("streets", "simulated"),
    "train-streets": ("streets", "trained"),
    "suites": ("over_suites", "simulated"),
    "train-fast": ("training_speed", "fast"),
    "train-paper": ("training_speed", "paper"),
    "plan": ("gpu_programs", "plan"),
}
"""The module and the function that measures each part: Settings -> a document."""


def main(part: str, settings: str) -> int:
    """Measure one part."""
    warnings.filterwarnings("ignore", "Error (reading|writing) persistent compilation cache")  # a full disk
    module, name = PROGRAMS[part]
    try:
        program: Callable[[Settings], Any] = getattr(import_module(f"jaxwalk.bench.{module}"), name)
        print(json.dumps(program(TypeAdapter(Settings).validate_json(settings)), allow_nan=False))
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
