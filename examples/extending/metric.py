"""Add a metric: rows from recorded episodes, and numbers with intervals from rows."""

from dataclasses import dataclass

import numpy as np

from jaxwalk import Street, measure, summarise
from jaxwalk.evaluation import play
from jaxwalk.metrics import METRICS, Estimate, Metric
from jaxwalk.metrics.statistics import interval, ratio
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.scenarios import Drawn


@dataclass(frozen=True)
class TopSpeeds:
    """One row per episode."""

    fastest: np.ndarray
    """Highest speed of the car [m/s]."""


@dataclass(frozen=True)
class TopSpeed:
    """The numbers in the summary and in its JSON."""

    mean: Estimate
    """Mean over episodes of the car's highest speed [m/s]."""


def measure_top_speed(recording):
    """Return the highest speed of each episode."""
    return TopSpeeds(recording.trajectory.car_speed.max(axis=0))


def summarise_top_speed(rows, sums) -> TopSpeed:
    """Return the mean with its 95 % interval, from sums over resampled episodes."""
    mean = ratio(sums[TOP_SPEED]["fastest"], sums[TOP_SPEED]["episodes"])
    return TopSpeed(mean=interval(mean, rows.episodes))


TOP_SPEED = Metric(
    name="top_speed",
    measure=measure_top_speed,
    columns=lambda rows: {"fastest": rows[TOP_SPEED].fastest, "episodes": np.ones(rows.episodes)},
    summarise=summarise_top_speed,
)

street = Street.create()
scenarios, keys = Drawn(street, seed=0).take(np.arange(64))
trajectory = play(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, scenarios, keys)
summary = summarise(measure(trajectory, metrics=(*METRICS, TOP_SPEED)))
print("the car's top speed is {0.value:.2f} m/s [{0.low:.2f}, {0.high:.2f}]".format(summary[TOP_SPEED].mean))
