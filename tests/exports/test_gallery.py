"""Incidents of the gallery, replayed: all are described, however many are played at once."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.evaluation import ReplayError, evaluate, find_incidents
from jaxwalk.exports.gallery import Cast, situations
from jaxwalk.policies import AlwaysGo, ConstantSpeed, RouteFollower
from jaxwalk.scenarios import Drawn

PAIR = "blind", "walkers"
AT_ONCE = 4


@pytest.fixture
def some(street, monkeypatch):
    """More incidents than are played at once, and the rows that they are from."""
    monkeypatch.setattr("jaxwalk.evaluation.batches.BATCH", AT_ONCE)
    rows = evaluate(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, Drawn(street, 7, 24))
    found = find_incidents(rows, most=8)
    assert len(found.scenario) > AT_ONCE
    return found, rows


def cast(street, driver):
    return Cast(street, {"blind": driver}, {"walkers": AlwaysGo()}, 7)


def test_incidents_are_described_a_batch_at_a_time(street, some):
    incidents, rows = some
    found = situations(cast(street, RouteFollower()), PAIR, incidents, rows)
    alone = [
        situations(cast(street, RouteFollower()), PAIR, incidents.some(slice(i, i + 1)), rows)
        for i in range(len(incidents.scenario))
    ]
    for name, column in vars(found).items():
        np.testing.assert_array_equal(column, np.concatenate([vars(one)[name] for one in alone]), err_msg=name)


def test_a_driver_that_does_something_else_is_named(street, some):
    with pytest.raises(ReplayError, match="blind among walkers does not do the same again"):
        situations(cast(street, ConstantSpeed(throttle=0.0)), PAIR, *some)
