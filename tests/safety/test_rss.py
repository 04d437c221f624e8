"""RSS on open ground: every way worked out by hand."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.safety.rss import (
    PERSON,
    Response,
    braking_way,
    forward_way,
    near_sector,
    sped_up,
    turn_until_response,
)

PAPER_CAR = Response(reaction=1.0, acceleration=3.0, braking=3.0, fastest=8.33)


@pytest.mark.parametrize(
    ("speed", "way"),
    [
        (0.0, 0.25 + 1.0**2 / 4),  # 0.5 s at 2 m/s2, then 1 m/s away at 2 m/s2
        (1.4, (1.4 + 2.4) / 2 * 0.5 + 2.4**2 / 4),
        (2.2, 2.35 * 0.15 + 2.5 * 0.35 + 2.5**2 / 4),  # at 2.5 m/s after 0.15 s, and no faster
        (3.0, 3.0 * 0.5 + 3.0**2 / 4),  # is faster already: keeps its speed
    ],
)
def test_how_far_somebody_on_foot_needs_to_stand(speed, way):
    assert braking_way(jnp.array(speed), PERSON) == pytest.approx(way)


@pytest.mark.parametrize(("speed", "way"), [(0.0, 1.5 + 3**2 / 6), (5.0, 6.5 + 8**2 / 6), (8.33, 8.33 + 8.33**2 / 6)])
def test_how_far_the_papers_car_needs(speed, way):
    assert braking_way(jnp.array(speed), PAPER_CAR) == pytest.approx(way)


@pytest.mark.parametrize(
    ("speed", "way"),
    [
        (0.0, 2 * 1.0**2 / 2),  # stands after 0.5 + 1 / 2 s, if it brakes
        (1.4, 1.95 * 0.55 + 2.5 * 1.15),  # after 0.5 + 2.4 / 2 s; at 2.5 m/s after 0.55 s
    ],
)
def test_how_far_who_goes_on_comes_meanwhile(speed, way):
    assert forward_way(jnp.array(speed), PERSON) == pytest.approx(way)


def test_nobody_brakes_in_a_longer_way_than_they_go_on():
    speeds = jnp.linspace(0, 9, 50)
    for response in (PERSON, PAPER_CAR):
        assert (forward_way(speeds, response) >= braking_way(speeds, response) - 1e-5).all()


def test_speeding_up_ends_at_the_highest_speed():
    way, after = sped_up(jnp.array([1.5, 4.0]), 1.0, PERSON)
    np.testing.assert_allclose(after, [2.5, 4.0])
    np.testing.assert_allclose(way, [2.0 * 0.5 + 2.5 * 0.5, 4.0])


def test_how_far_somebody_on_foot_can_turn():
    np.testing.assert_allclose(turn_until_response(jnp.array([0.0, 1.4])), [np.pi, 0.95 / 2], rtol=1e-6)


@pytest.mark.parametrize(
    ("point", "half_angle", "away"),
    [
        ((3, 0), np.pi / 4, 1.0),  # beyond the arc
        ((1, 0.9), np.pi / 4, 0.0),  # inside
        ((0, 1), np.pi / 4, np.sqrt(0.5)),  # beside the edge at 45 degrees
        ((0, -1), np.pi / 4, np.sqrt(0.5)),
        ((-1, 0), np.pi / 4, 1.0),  # behind the apex
        ((3, 3), np.pi / 4, np.sqrt(18) - 2),
        ((-3, 0), np.pi, 1.0),  # the whole circle
        ((-1.9, 0.1), np.pi, 0.0),
    ],
)
def test_how_far_a_point_is_from_a_sector(point, half_angle, away):
    def is_near(within):
        return bool(near_sector(tuple(jnp.array(point, float)), jnp.array(half_angle), jnp.array(2.0), within))

    assert is_near(away + 1e-5)
    assert away == 0 or not is_near(away - 1e-5)


def test_a_point_is_as_far_as_the_nearest_of_many_points_of_the_sector():
    random = np.random.default_rng(1)
    half, radius = random.uniform(0, np.pi, 300), random.uniform(0.1, 4, 300)
    point, within = random.uniform(-6, 6, (2, 300)), random.uniform(0.05, 3, 300)
    angle = np.linspace(-half, half, 400)[:, None] + np.zeros((1, 60, 1))
    away = np.linspace(0, radius, 60)[None]
    nearest = np.hypot(away * np.cos(angle) - point[0], away * np.sin(angle) - point[1]).min(axis=(0, 1))
    found = np.asarray(near_sector(tuple(jnp.asarray(point)), *map(jnp.asarray, (half, radius, within))))
    clear = np.abs(nearest - within) > 0.05  # the points of the sector are that close together
    assert clear.sum() > 250
    assert 50 < found.sum() < 250
    np.testing.assert_array_equal(found[clear], (nearest < within)[clear])
