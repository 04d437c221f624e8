from __future__ import annotations

import jax.numpy as jnp
import pytest

from jaxwalk.safety.fuzzy import (
    FuzzyLimits,
    comes_into_the_way,
    critical_fuzzy_safety,
    fuzzy_braking,
    proactive_fuzzy_safety,
)

LIMITS = FuzzyLimits()
SAFE, UNSAFE = 7.5 + 100 / 8 + 2, 7.5 + 100 / 12  # at 10 m/s towards somebody who stands: 22 and 15.83 m


@pytest.mark.parametrize(
    ("gap", "expected"), [(SAFE + 2, 0), (SAFE + 9, 0), (UNSAFE + 2, 1), (3, 1), ((SAFE + UNSAFE) / 2 + 2, 0.5)]
)
def test_proactive_fuzzy_safety_between_safe_and_unsafe(gap, expected):
    found = proactive_fuzzy_safety(jnp.float32(gap), jnp.float32(10), jnp.float32(0), LIMITS)
    assert found == pytest.approx(expected, abs=1e-5)


def test_a_leader_who_drives_away_needs_way_to_stop_too():
    """At 7 m/s it needs 49 / 14 = 3.5 m; one who comes towards the car counts as standing."""
    gap = jnp.float32((SAFE + UNSAFE) / 2 + 2 - 3.5)
    assert proactive_fuzzy_safety(gap, jnp.float32(10), jnp.float32(7), LIMITS) == pytest.approx(0.5, abs=1e-5)
    gap = gap + 3.5
    assert proactive_fuzzy_safety(gap, jnp.float32(10), jnp.float32(-7), LIMITS) == pytest.approx(0.5, abs=1e-5)


@pytest.mark.parametrize(
    ("gap", "acceleration", "expected"),
    [
        (20, 0, 0),  # 7.5 + 100 / 8
        (7.5 + 100 / 12, 0, 1),
        (7.5 + (100 / 8 + 100 / 12) / 2, 0, 0.5),
        (12.5, -4, 0),  # (10 - 1.5) 0.75 + 7^2 / 8
        (6.375 + 49 / 12, -4, 1),
        (6.375 + (49 / 8 + 49 / 12) / 2, -8, 0.5),  # harder braking than 4 m/s2 isn't counted on
    ],
)
def test_critical_fuzzy_safety_between_safe_and_unsafe(gap, acceleration, expected):
    found = critical_fuzzy_safety(jnp.float32(gap), jnp.float32(10), jnp.float32(0), jnp.float32(acceleration), LIMITS)
    assert found == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(("gap", "expected"), [(0.4, 1), (0.6, 0)])
def test_a_car_that_stands_within_its_reaction_time_needs_its_way_until_then(gap, expected):
    """From 2 m/s at -4 m/s2: 2^2 / 8 = 0.5 m."""
    found = critical_fuzzy_safety(jnp.float32(gap), jnp.float32(2), jnp.float32(0), jnp.float32(-4), LIMITS)
    assert found == expected


def test_nothing_is_critical_that_no_one_approaches():
    assert critical_fuzzy_safety(jnp.float32(1), jnp.float32(3), jnp.float32(3), jnp.float32(0), LIMITS) == 0


@pytest.mark.parametrize(("proactive", "critical", "expected"), [(0, 0, 0), (0.5, 0, 2), (1, 0.5, 5), (1, 1, 6)])
def test_braking_by_both(proactive, critical, expected):
    assert fuzzy_braking(jnp.float32(proactive), jnp.float32(critical), LIMITS) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("aside", "approach", "expected"),
    [
        (0, 0, True),  # in the way
        (0, -1, True),
        (3, 0, False),  # beside it
        (3, -1, False),
        (3, 1.5, True),  # 2 s; the car is past after 20 m at 10 m/s
        (3.1, 1.5, True),  # 2.07 s: 0.1 s are granted
        (3.2, 1.5, False),
    ],
)
def test_who_comes_into_the_way(aside, approach, expected):
    found = comes_into_the_way(jnp.float32(aside), jnp.float32(approach), jnp.float32(20), jnp.float32(10))
    assert bool(found) == expected
