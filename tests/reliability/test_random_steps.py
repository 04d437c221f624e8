"""The script of ten million steps would see what it looks for."""

import numpy as np

from jaxwalk.sim.observation import OBSERVATIONS, bounds
from reliability.random_steps import wrong


def test_wrong_numbers_are_told_by_name(street):
    seen = {"state": np.zeros((2, 3))}
    for role, sets in OBSERVATIONS.items():
        for name in sets:
            seen[f"{role} {name}"] = np.stack(bounds(street.world, role, name))
    assert wrong(street, seen) == []
    seen["state"][1, 2] = np.inf
    seen["driver privileged"][0, 7] -= 1
    seen["pedestrian kerb"][1, 0] = np.nan
    told = " ".join(wrong(street, seen))
    assert "state: not finite at [2]" in told
    assert "driver privileged: feature 7 was in [" in told
    assert "pedestrian kerb: not finite at [0]" in told
