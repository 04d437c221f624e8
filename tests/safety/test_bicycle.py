"""The kinematic bicycle, by hand."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.safety.bicycle import held_turn, slip

WHEELBASE = 2.5
TO_SLIP_30 = np.arctan(2 * np.tan(np.pi / 6))
"""The steering angle of a slip angle of 30 degrees: sin beta is 1 / 2, and the circle's radius L / (2 sin beta) L."""


def test_the_slip_angle():
    cos, sin = slip(jnp.array([0.0, TO_SLIP_30]))
    np.testing.assert_allclose(cos, [1, np.sqrt(3) / 2], rtol=1e-6)
    np.testing.assert_allclose(sin, [0, 0.5], rtol=1e-6)


@pytest.mark.parametrize("side", [1, -1])
def test_a_quarter_of_a_circle(side):
    """From the direction of 30 degrees, by 90: a chord of R sqrt(2) at 75 degrees."""
    ahead, left, turn = held_turn(jnp.array(WHEELBASE * np.pi / 2), jnp.array(side * TO_SLIP_30), WHEELBASE)
    chord = WHEELBASE * np.sqrt(2)
    expected = [chord * np.cos(np.radians(75)), side * chord * np.sin(np.radians(75)), side * np.pi / 2]
    np.testing.assert_allclose([ahead, left, turn], expected, rtol=1e-5)


def test_straight_on():
    np.testing.assert_allclose(held_turn(jnp.array(7.0), jnp.array(0.0), WHEELBASE), [7, 0, 0])
