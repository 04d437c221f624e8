from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.safety.idm import FollowingStyle, idm_acceleration

STYLE = FollowingStyle()
FREE = jnp.inf


def accelerates(speed, gap=FREE, closing=0.0, desired=20.0):
    return float(idm_acceleration(jnp.float32(speed), desired, jnp.float32(gap), jnp.float32(closing), STYLE))


@pytest.mark.parametrize(("speed", "expected"), [(0, 1.5), (10, 1.5 * 15 / 16), (20, 0)])
def test_without_a_leader_a_car_reaches_its_speed(speed, expected):
    assert accelerates(speed) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("speed", "gap"), [(0, 2.0), (5, 7 / (1 - 1 / 256) ** 0.5), (10, 12 / (15 / 16) ** 0.5)])
def test_at_the_equilibrium_gap_a_car_keeps_its_speed(speed, gap):
    """(s0 + v T) / sqrt(1 - (v / v0)^4) with s0 = 2 m, T = 1 s, v0 = 20 m/s."""
    assert accelerates(speed, gap) == pytest.approx(0, abs=1e-5)


def test_braking_for_a_leader_who_stands():
    """s* = 2 + 10 + 100 / (2 sqrt 3) = 40.87 m; 1.5 (1 - 1/16 - (40.87 / 20)^2) = -4.86 m/s2."""
    assert accelerates(10, gap=20, closing=10) == pytest.approx(-4.857, abs=1e-3)


def test_a_leader_who_leaves_never_shortens_the_standstill_gap():
    """s* isn't below s0: 1.5 (1 - 1/16 - (2 / 4)^2)."""
    assert accelerates(10, gap=4, closing=-20) == pytest.approx(1.5 * (15 / 16 - 0.25), rel=1e-6)


def test_a_gap_of_nothing_is_no_division_by_zero():
    assert np.isfinite(accelerates(5, gap=0, closing=5)) and accelerates(5, gap=0, closing=5) < -100
