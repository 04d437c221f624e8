"""What the recipes pay: weights of the reward terms (`jaxwalk.sim.reward`). ``docs/recipes.md`` gives reasons.

No JAX import, so that a command line starts quickly.
"""

from __future__ import annotations

from typing import Final

DRIVER_WEIGHTS: Final[dict[str, dict[str, float]]] = {
    "fast": {
        "progress": 0.5,
        "goal": 20.0,
        "collision": -100.0,
        "closeness": -1.0,
        "off_lane": -0.02,
        "misaligned": -0.1,
        "time": -0.02,
    },
    "paper": {
        "crow_progress": 1.0,
        "goal": 50.0,
        "collision": -50.0,
        "crosswalk_speeding": -0.3,
        "jaywalker_speeding": -0.3,
        "off_lane": -0.05,
        "misaligned": -0.1,
    },
}
"""What the car is paid for, by recipe."""

PEDESTRIAN_WEIGHTS: Final[dict[str, dict[str, float]]] = {
    "fast": {"waited": -0.02, "collision": -100.0},
    "paper": {"walked": 2.0, "arrival": 5.0, "collision": -25.0, "waiting": 0.3},
}
"""What a pedestrian is paid for, by recipe."""
