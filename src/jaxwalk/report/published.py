"""The paper's numbers: Aryan et al. (2026), section IV. Rates in percent, speeds in m/s, distances in m, times in s."""

from __future__ import annotations

BASELINES: dict[str, tuple[float, float]] = {
    "random": (11.0, 25.0),
    "constant-speed": (23.0, 39.0),
    "rule-based": (35.0, 33.0),
    "rule-based-braking": (33.0, 35.0),
}
"""Goal and collision rates of the rules (section IV-A); the paper does not state the population."""

TRAINED: dict[tuple[str, str], tuple[float, float]] = {
    ("single-agent", "always-go"): (65.0, 20.0),
    ("single-agent", "learned"): (65.0, 16.0),
    ("co-trained", "always-go"): (76.0, 16.0),
    ("co-trained", "learned"): (78.0, 14.0),
}
"""Goal and collision rates by driver and population (Table III)."""
DRIVERS = frozenset(BASELINES) | {driver for driver, _ in TRAINED}
"""The drivers whose rates the paper has."""

ABLATION: dict[float, tuple[float, float]] = {
    0.0: (77.0, 15.0),
    0.1: (77.0, 15.0),
    0.25: (76.0, 16.0),
    0.6: (73.0, 18.0),
    1.0: (64.0, 28.0),
}
"""Goal and collision rates of the co-trained driver by jaywalk multiplier, among always-go (section IV-D)."""
JAYWALK_SHARE: dict[float, float] = {0.0: 0.0, 0.1: 5.0, 0.25: 13.0, 0.6: 30.0, 1.0: 50.0}
"""Share of crossings that are jaywalks, by multiplier."""

SPEED_GAP = 2.65
"""Car speed near jaywalkers minus near crosswalk users, nearest pedestrian within 3 m (section IV-B)."""
SPEEDS = (5.43, 8.08)
"""Car speed near crosswalk users and near jaywalkers, within 3 m."""
SPEED_GAP_FARTHER = (0.80, 1.60)
"""Range of the differences at 3 to 12 m."""

CROSSINGS_JAYWALK, COLLISIONS_JAYWALK = 13.0, 62.0
"""Jaywalking's share of the crossings and of the collisions (section IV-B)."""
QUARTERS = (3.2, 9.4, 15.7, 21.6)
"""Jaywalk rate by quarter of the trait (section IV-B)."""
APPROACH = {"jaywalk": 3.25, "crosswalk": 3.49}
"""5th percentile of the minimum approach by encounter type (section IV-B)."""
BRAKING = 3.38
"""Mean time from a jaywalker's road entry to braking (section IV-B)."""
