from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.safety.stopping import last_moment, ramp, time_to_collision


def test_time_to_collision():
    """Over a gap that doesn't shrink there is none, and who overlaps collides now."""
    gap, closing = jnp.array([10.0, 10.0, 10.0, -1.0]), jnp.array([5.0, 0.0, -3.0, 5.0])
    np.testing.assert_allclose(time_to_collision(gap, closing), [2, np.inf, np.inf, 0], rtol=1e-6)


@pytest.mark.parametrize("speed", [2.0, 8.33, 13.9])
def test_who_brakes_at_the_last_moment_stops_in_front_of_it(speed):
    """The gap at that time to collision is the braking distance and what is driven in the spare time."""
    gap = speed * float(last_moment(jnp.float32(speed), 3.0, 0.4))
    assert gap == pytest.approx(speed**2 / (2 * 3) + 0.4 * speed, rel=1e-6)


def test_the_ramp_of_the_regulation():
    """0.774 g after 0.6 s, at 12.65 m/s3."""
    found = ramp(jnp.array([-0.2, 0.0, 0.1, 0.3, 0.6, 2.0]), 0.774 * 9.81, 0.6)
    np.testing.assert_allclose(found, [0, 0, 1.2655, 3.7965, 7.593, 7.593], rtol=1e-3)
