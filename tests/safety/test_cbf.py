"""Barrier functions, by hand."""

from __future__ import annotations

import jax.numpy as jnp
import pytest

from jaxwalk.safety.cbf import collision_cone, least_allowed

PLACE = jnp.array(10.0), jnp.array(0.0)
"""10 m ahead: a circle of 6 m leaves a root of 8."""


@pytest.mark.parametrize(
    ("velocity", "h"),
    [
        ((-5, 0), -50 + 5 * 8),  # straight at it
        ((0, -5), 5 * 8),  # across
        ((-4, 3), 0),  # along the tangent: the cone's edge
        ((5, 0), 50 + 5 * 8),  # away
        ((0, 0), 0),
    ],
)
def test_the_collision_cone(velocity, h):
    assert collision_cone(PLACE, tuple(jnp.array(velocity, float)), 6.0) == pytest.approx(h, abs=1e-5)


def test_inside_the_circle_the_root_is_0():
    assert collision_cone((jnp.array(3.0), jnp.array(4.0)), (jnp.array(-1.0), jnp.array(0.5)), 6.0) == -3 + 2


@pytest.mark.parametrize(
    ("now", "speed", "after", "least"),
    [(10, 2, 2, 8), (10, 2, 4, 8), (10, 2, 1, 4), (10, 2, 0, 0), (-10, 2, 1, -8), (-10, 2, 4, -8), (0, 0, 1, 0)],
)
def test_how_far_h_may_fall(now, speed, after, least):
    found = least_allowed(*jnp.array([now, speed, after], float), 0.2)
    assert found == pytest.approx(least)
