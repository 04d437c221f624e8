"""The risk curves give the figures that their authors published."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxwalk.metrics.injury import MEAN_HOOD, monfort_mueller_fatal, monfort_mueller_mais3, rosen_sander_fatal

MPH = 0.44704
PICKUP = 75 + 13 * 2.54  # IIHS: a median pickup's hood is 13 inches higher than a median car's [cm]


@pytest.mark.parametrize(
    ("risk", "mph", "hood", "published"),
    [
        # IIHS's news release on the study (10 December 2024), as the press quoted it
        (monfort_mueller_mais3, 15, MEAN_HOOD, 0.10),
        (monfort_mueller_mais3, 20, MEAN_HOOD, 0.18),
        (monfort_mueller_mais3, 35, MEAN_HOOD, 0.67),
        (monfort_mueller_mais3, 27, 75, 0.30),
        (monfort_mueller_mais3, 27, PICKUP, 0.62),
        (monfort_mueller_fatal, 35, MEAN_HOOD, 0.19),
        (monfort_mueller_fatal, 50, MEAN_HOOD, 0.80),
    ],
)
def test_monfort_and_mueller_agree_with_what_iihs_published(risk, mph, hood, published):
    assert risk(mph * MPH, hood) == pytest.approx(published, abs=0.03)


def test_coefficients_by_hand():
    """10 km/h faster and 10 cm higher than the means: the logits are sums of their coefficients."""
    speed, hood = (42.79 + 10) / 3.6, 85.25 + 10
    assert monfort_mueller_mais3(speed, hood) == pytest.approx(1 / (1 + np.exp(0.46 - 0.91 - 0.39 - 0.2)))
    assert monfort_mueller_fatal(speed, hood) == pytest.approx(1 / (1 + np.exp(3.28 - 1.23 - 0.47)))
    assert monfort_mueller_mais3(10.0) == monfort_mueller_mais3(10.0, 75)
    assert rosen_sander_fatal(100 / 3.6) == pytest.approx(1 / (1 + np.exp(6.9 - 9.0)))


def test_rosen_and_sander_agree_with_their_abstract():
    # the risk at 50 km/h is more than twice that at 40 km/h and more than five times that at 30 km/h
    at_30, at_40, at_50 = rosen_sander_fatal(np.array([30, 40, 50]) / 3.6)
    assert at_50 > 2 * at_40
    assert at_50 > 5 * at_30
    assert at_50 == pytest.approx(0.083, abs=0.001)


@given(st.floats(0, 40), st.floats(0.01, 10))
def test_risks_grow_with_speed(speed, more):
    for risk in (monfort_mueller_mais3, monfort_mueller_fatal, rosen_sander_fatal):
        assert 0 < risk(speed) < risk(speed + more) < 1


@given(st.floats(0, 25))
def test_who_dies_was_seriously_injured(speed):
    # (two fits with rounded coefficients: beyond 100 km/h, where there were hardly any crashes, they cross)
    assert monfort_mueller_fatal(speed) < monfort_mueller_mais3(speed)
