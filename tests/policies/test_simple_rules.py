"""The clearance rule and people who accept gaps, on observations made by hand."""

from __future__ import annotations

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxwalk.policies.cautious_rule import CautiousRule
from jaxwalk.policies.clearance_rule import ClearanceRule
from jaxwalk.policies.gap_acceptance import INTERCEPT, PER_SECOND, GapAccepting
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.manoeuvres import FAR
from jaxwalk.sim.observation import AWARE, FOOTPRINT, part, size
from jaxwalk.sim.pedestrian_features import KERB_CAR_DISTANCE

KEYS = jax.random.split(jax.random.key(0), 2)
ONE = KEYS[:1]


@eqx.filter_jit
def _act(policy, *now):
    return policy.act(*now)


def act(policy, *now):
    """What a policy does and remembers, computed by one program, as NumPy's arrays."""
    return jax.tree.map(np.asarray, _act(policy, *now))


@pytest.mark.parametrize(
    ("brake", "hold", "accelerate", "throttle"),
    [(5, 5, 5, 1), (5, 5, 0.9, 0), (5, 0.9, 0.9, -1), (0, 0, 0, -1), (0, 0, 1.1, 1)],
)
def test_the_clearance_rule_takes_the_fastest_that_is_clear(brake, hold, accelerate, throttle):
    seen = np.zeros((size("driver", FOOTPRINT), 1), np.float32)
    seen[part("driver", FOOTPRINT, "clearance"), 0] = np.array([brake, hold, accelerate]) / FAR
    seen[part("driver", FOOTPRINT, "route")] = np.tile([[1.0], [0.0]], (8, 1))
    action, _ = act(ClearanceRule(), ONE, None, seen)
    assert action[:, 0].tolist() == [throttle, 0]


@pytest.mark.parametrize(
    ("hidden", "speed", "clear", "throttle"),
    [
        ((), 8.0, 5, 1),
        ((7,), 8.0, 5, -1),
        ((0,), 3.25, 5, -0.25),
        ((0,), 2.0, 5, 1),
        ((0,), 2.0, 0, -1),
        ((8, 15), 8.0, 5, 1),
    ],
)
def test_the_cautious_rule_slows_where_a_place_close_ahead_is_hidden(hidden, speed, clear, throttle):
    """Places 0 to 7 are the right and left ones beside the first four points of the route; others are too far."""
    seen = np.zeros((size("driver", AWARE), 1), np.float32)
    seen[part("driver", AWARE, "clearance"), 0] = clear / FAR
    seen[part("driver", AWARE, "speed")] = speed / SPEED
    seen[part("driver", AWARE, "route")] = np.tile([[1.0], [0.0]], (8, 1))
    seen[part("driver", AWARE, "hidden_sides").start + np.array(hidden, int), 0] = 1
    action, _ = act(CautiousRule(), ONE, None, seen)
    assert action[:, 0].tolist() == pytest.approx([throttle, 0], abs=1e-6)


def kerb(gap, *, deciding=True, speed=5.0, people=4000):
    """What people see, all alike, in each of two episodes."""
    seen = np.zeros((size("pedestrian", "kerb"), people, 2), np.float32)
    seen[part("pedestrian", "kerb", "decides")] = deciding
    seen[part("pedestrian", "kerb", "place").start] = gap * speed / KERB_CAR_DISTANCE
    seen[part("pedestrian", "kerb", "car_motion").start] = speed / 8.33
    return seen


def go(memory, *args, **more):
    return act(GapAccepting(), KEYS, memory, kerb(*args, **more))


@pytest.mark.parametrize("gap", [2.0, 5.0, INTERCEPT / PER_SECOND, 8.0, 13.0])
def test_gaps_are_accepted_as_often_as_was_observed(gap):
    critical = go(GapAccepting().init((4000,), (2,)), gap, deciding=False)[1]
    accepted, kept = go(critical, gap)
    expected = 1 / (1 + np.exp(INTERCEPT - PER_SECOND * gap))
    assert accepted.mean() == pytest.approx(expected, abs=0.02)
    np.testing.assert_array_equal(kept, critical)  # who decides does not draw again: time makes nobody braver
    assert not np.array_equal(accepted[:, 0], accepted[:, 1], equal_nan=True)


def test_people_go_when_there_is_nothing_to_wait_for():
    nobody = np.full((4000, 2), 100.0, np.float32)
    assert go(nobody, 0.1)[0].sum() == 0
    assert go(nobody, 0.1, deciding=False)[0].all()
    assert go(nobody, 0.1, speed=0.2)[0].all()
    assert go(nobody, -0.1)[0].all()
