"""Between which numbers each feature of an observation lies, derived from the map and the world's rules.

Car and people never leave the map, so nothing is farther away than its diagonal; speeds, angles and times have their
limits in `SimConfig`, or are capped by the observation itself (`jaxwalk.sim.observation`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from jaxwalk.maps.road_map import ROUTE_SPACING
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS, Tables
from jaxwalk.sim.observation import ABSENT, KERB_CAR_DISTANCE, LAYOUTS, SPEED
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.world import World

ROUNDING = 1e-3
"""Bounds are this much wider than derived: single precision rounds."""

Bound = tuple[float, float]

SHARE, SIGNED = (0.0, 1.0), (-1.0, 1.0)
"""Of flags, traits, positions on the map and capped distances; of cosines and of commands."""


def bounds(world: World, role: str, name: str) -> tuple[Float[np.ndarray, " feature"], Float[np.ndarray, " feature"]]:
    """Lowest and highest values of each feature of an observation set; ValueError for an unknown one."""
    if name not in LAYOUTS[role]:
        raise ValueError(f"no observation set '{name}' for the {role}; there are: {', '.join(LAYOUTS[role])}")
    diagonal = float(np.hypot(np.asarray(world.maps.width), np.asarray(world.maps.height)).max())
    config = world.rules.config
    parts = _of_driver(world.tables, config, diagonal) if role == "driver" else _of_pedestrians(config, diagonal)
    rows: list[Bound] = []
    for part, size in LAYOUTS[role][name].items():
        pattern = parts[part]
        rows += list(pattern) * (size // len(pattern))
    low, high = np.array(rows, np.float32).T
    return low - np.float32(ROUNDING), high + np.float32(ROUNDING)


def _of_driver(tables: Tables, config: SimConfig, diagonal: float) -> dict[str, Sequence[Bound]]:
    """Bounds of each part of the driver's sets; a part of several features repeats its pattern."""
    speed, walk = config.max_speed / SPEED, config.fastest_walk / SPEED
    lengths = np.asarray(tables.finish)[..., 2]
    farthest = (tables.course.shape[-2] - 1) * ROUTE_SPACING  # what `along` is held to, also on a shorter route
    to_go = (float(lengths.min()) - farthest) / ABSENT, min(float(lengths.max()) / ABSENT, 2.0)
    near = _both(max(diagonal, ABSENT) / ABSENT)
    return {
        "position": [SHARE],
        "heading": [SIGNED],
        "speed": [(0.0, speed)],
        "steering": [SIGNED],
        "goal": [_both(diagonal / ABSENT)],
        "goal_distance": [(0.0, diagonal / ABSENT)],
        "lateral": [_both(diagonal / 2)],
        "heading_error": [SIGNED],
        "people": [near, near, _both(walk), _both(walk)],
        "to_go": [to_go],
        "route": [_both(diagonal / (POINT_SPACING * point)) for point in POINTS for _ in "xy"],
        "clearance": [SHARE],
        "margin": [SHARE],
        "conflict": [SHARE],
        "tendencies": [SHARE],
        "clearances": [SHARE],
    }


def _of_pedestrians(config: SimConfig, diagonal: float) -> dict[str, Sequence[Bound]]:
    """Bounds of each part of the pedestrians' sets."""
    speed = config.max_speed / SPEED
    return {
        "position": [SHARE],
        "velocity": [_both(config.fastest_walk / 2)],
        "traits": [SHARE],
        "next_waypoint": [_both(diagonal / ABSENT)],
        "surface": [SHARE],
        "on_jaywalk": [SHARE],
        "car_position": [_both(diagonal / ABSENT)],
        "car_velocity": [_both(speed)],
        "nearest_other": [_both(max(diagonal, ABSENT) / ABSENT)],
        "decides": [SHARE],
        "place": [_both(diagonal / KERB_CAR_DISTANCE)],
        "car_motion": [(0.0, speed), SIGNED, SIGNED],
        "direction": [SIGNED],
        "times": [SIGNED, SHARE, SIGNED],
        "miss": [SHARE],
        "pace": [(config.slowest_walk / 2, config.fastest_walk / 2)],
        "jaywalk": [SHARE],
        "to_kerb": [(-1.0, config.kerb_distance)],
    }


def _both(most: float) -> Bound:
    """As far to either side."""
    return -most, most
