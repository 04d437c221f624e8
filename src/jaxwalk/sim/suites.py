"""Suites: named places to test a driver, so that two testers mean the same. This module imports no JAX."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Where:
    """Where policies are to play. What is left out is as the run folders have it, else as on the paper's street."""

    maps: tuple[str, ...] = ()
    """Bundled maps, map files or generated streets."""
    world: str | None = None
    """A name in `jaxwalk.sim.sim_config.WORLDS`."""
    people: int | None = None
    """Pedestrians in an episode."""


SUITES: Final = {
    "paper": Where(("paper",), "paper", 12),
    "paper-footprint": Where(("paper",), "paper-footprint", 12),
    "town": Where(("test:200",), "town", 12),
    "crowd": Where(("test:200",), "town", 72),
    "blind-corner": Where(("parked-test:20",), "blind-corner", 48),
    "arterial": Where(("arterial:20",), "arterial", 48),
    "unseen-ranges": Where(("unseen-ranges:200",), "town", 12),
}
"""The suites by name. ``docs/suites.md`` says what each is for, and what rules and the oracle reach on it."""
CRASH_SUITES: Final = ("euro-ncap-style", "fmvss-127", "r152")
"""The suites of crash tests that ship with jaxwalk (``docs/crash-tests.md``)."""
CRASH_WORLD: Final = "test-track"
"""The world of crash tests, and the street of those that ship with jaxwalk."""
