"""Estimate how badly a pedestrian is hurt: published risk curves over the speed of the car at impact.

All were fitted to real crashes with the front of a moving car. They use the car's speed, not the relative speed.
"""

from __future__ import annotations

import numpy as np

KMH = 3.6
"""1 m/s in km/h."""
MEDIAN_CAR = 75.0
"""Height of the leading edge of the hood of the median passenger car in Monfort and Mueller's sample [cm]."""
MEAN_SPEED = 42.79
"""Mean impact speed of their sample [km/h]; their covariates are centred."""
MEAN_HOOD = 85.25
"""Mean height of the hood's leading edge of their sample [cm]."""


def monfort_mueller_mais3(speed, hood_height=MEDIAN_CAR):
    """Return the risk of a serious injury or worse (MAIS 3+ or death) of a pedestrian aged 16 or more.

    Monfort and Mueller (2025), *A modern injury risk curve for pedestrian injury in the United States*, table 4, at the
    mean age (42.4 years) and share of men (0.59) of their 202 crashes. ``docs/metrics.md`` says how it was checked.

    Args:
        speed: speed of the car at impact [m/s]; any shape.
        hood_height: height of the leading edge of the car's hood [cm]; broadcasts with ``speed``.
    """
    faster, higher = KMH * np.asarray(speed, float) - MEAN_SPEED, np.asarray(hood_height, float) - MEAN_HOOD
    return _logistic(-0.460 + 0.091 * faster + 0.039 * higher + 0.002 * faster * higher)


def monfort_mueller_fatal(speed, hood_height=MEDIAN_CAR):
    """Return the risk of death, from the same source, for the same people and arguments as `monfort_mueller_mais3`."""
    faster, higher = KMH * np.asarray(speed, float) - MEAN_SPEED, np.asarray(hood_height, float) - MEAN_HOOD
    return _logistic(-3.280 + 0.123 * faster + 0.047 * higher)


def rosen_sander_fatal(speed):
    """Return the risk of death of an adult hit by the front of a passenger car.

    Rosén and Sander (2009), *Pedestrian fatality risk as a function of car impact speed*: 490 German cases (GIDAS).

    Args:
        speed: speed of the car at impact [m/s]; any shape.
    """
    return _logistic(-6.9 + 0.090 * KMH * np.asarray(speed, float))


def _logistic(x):
    """Return 1 / (1 + exp(-x))."""
    return 1 / (1 + np.exp(-x))
