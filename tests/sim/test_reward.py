"""Reward terms at their limits: what is predicted of a car and a person is put in by hand."""

from __future__ import annotations

from types import SimpleNamespace

import jax.numpy as jnp
import pytest

from jaxwalk.sim.reward import DRIVER_TERMS, PEDESTRIAN_TERMS, Transition


def step(speed, contact="disc"):
    """A step in which the only person waits, and the car keeps a speed; its top speed is 8 m/s."""
    world = SimpleNamespace(rules=SimpleNamespace(contact=contact, max_speed=8.0))
    car, people = SimpleNamespace(speed=jnp.float32(speed)), SimpleNamespace(going=jnp.array([False]))
    state = SimpleNamespace(vehicle=car, pedestrian=people)
    return Transition(world, None, state, state, None)


@pytest.mark.parametrize(
    ("ahead", "left", "speed", "paid"),
    [
        (7.9, 0.0, 5.0, True),
        (8.0, 0.0, 5.0, False),
        (0.1, 7.9, 5.0, True),
        (0.0, 5.0, 5.0, False),
        (5.0, 5.0, 2.1, True),
        (5.0, 5.0, 2.0, False),
    ],
)
def test_waiting_is_paid_before_a_car_nearer_than_8_m_and_faster_than_2(monkeypatch, ahead, left, speed, paid):
    seen = SimpleNamespace(ahead=jnp.array([ahead]), left=jnp.array([left]))
    monkeypatch.setattr("jaxwalk.sim.prediction.motion_of_people", lambda *_: seen)
    assert PEDESTRIAN_TERMS["waiting_anywhere"](step(speed)).tolist() == [paid]


@pytest.mark.parametrize(
    ("contact", "clearance", "paid"),
    [("disc", 0.75, 0.375), ("footprint", 0.75, 0.25), ("disc", 3.0, 0), ("footprint", 1.5, 0)],
)
def test_clearance_is_comfortable_from_3_m_on_or_from_half_of_it_by_footprint(monkeypatch, contact, clearance, paid):
    """At half the top speed, half of the shortfall is paid."""
    monkeypatch.setattr("jaxwalk.sim.prediction.clearance_at_held_speed", lambda *_: jnp.float32(clearance))
    assert float(DRIVER_TERMS["closeness"](step(4.0, contact))) == paid
