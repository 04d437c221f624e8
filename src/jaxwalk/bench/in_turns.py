"""Programs that are compared take turns of about a second.

So a machine that is faster now and slower then treats all alike, and the ratio of two speeds in one turn says more than
either speed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from jaxwalk.bench.benchmark_settings import Settings
from jaxwalk.bench.processes import tell
from jaxwalk.bench.simulation import Sets, build
from jaxwalk.sim.environment import Street

Turn = Callable[[], float]
"""Works for about a second and returns the speed [steps/s]."""


def take_turns(programs: Mapping[Any, Turn], turns: int) -> dict[Any, list[float]]:
    """Return the speeds of all programs, turn by turn. Each is called once before, uncounted, to compile."""
    for turn in programs.values():
        turn()
    speeds: dict[Any, list[float]] = {name: [] for name in programs}
    for _ in range(turns):
        for name, turn in programs.items():
            speeds[name].append(turn())
    for name, found in speeds.items():
        tell(f"{name}: {np.median(found):,.0f} steps/s, the median of {turns} turns")
    return speeds


def playing(street: Street, count: int, settings: Settings, sets: Sets) -> Turn:
    """Return the turn of a simulation of ``count`` environments that computes these observation sets."""
    program = build(street, count, settings.steps, settings.seed, sets)

    def turn() -> float:
        begun, played = time.perf_counter(), 0
        while time.perf_counter() - begun < settings.turn_seconds:
            played += int(program.play()[3].sum())
        return played / (time.perf_counter() - begun)

    return turn
