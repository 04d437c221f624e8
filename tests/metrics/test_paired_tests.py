"""Tests of pairs against worked examples."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.metrics import holm, mcnemar, paired_difference
from jaxwalk.metrics.paired_tests import SURE, _discordant


def test_mcnemar():
    # 9 against 1 of 10 discordant pairs: 2 * (1 + 10) / 2^10
    a = np.array([True] * 9 + [False] + [True] * 5)
    b = np.array([False] * 9 + [True] + [True] * 5)
    assert mcnemar(a, b) == pytest.approx(22 / 1024)
    assert mcnemar(a, a) == 1.0
    with pytest.raises((ValueError, TypeError)):  # TypeError: where shapes are checked
        mcnemar(a, b[1:])


def test_pairs_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match=r"paired outcomes need equal lengths, not \(3,\) and \(2,\)"):
        _discordant(np.ones(3, bool), np.ones(2, bool))


def test_paired_difference_of_bonett_and_price():
    # 40 pairs, 2 in A alone and 12 in B alone: 13/42 - 3/42 +- 1.96 sqrt((16/42 - (10/42)^2) / 42)
    a = np.array([True] * 2 + [False] * 38)
    b = np.array([False] * 2 + [True] * 12 + [False] * 26)
    found = paired_difference(a, b)
    assert (found.value, found.count) == (0.25, 40)
    assert (found.low, found.high) == pytest.approx((0.2381 - 0.1723, 0.2381 + 0.1723), abs=1e-4)
    assert paired_difference(b, a).low == -found.high


def test_agreement_in_all_pairs_leaves_doubt():
    never = np.zeros(100, bool)
    found = paired_difference(never, never)
    assert (found.value, found.low) == (0, -found.high)
    assert found.high == pytest.approx(1.96 * 2**0.5 / 102, rel=1e-3)
    assert paired_difference(~never[:1], never[:1]).low == -1
    assert paired_difference(never[:1], ~never[:1]).high == 1


def test_holm_on_a_worked_example():
    # Holm's procedure by hand: 0.005 x 4, 0.01 x 3, 0.03 x 2, and 0.04 x 1 is raised to the one before
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert holm([0.9, 0.8]) == (1.0, 1.0)
    assert holm([]) == ()
    assert max(holm([0.04])) < SURE < min(holm([0.03, 0.04])), "each alone is a difference, and together neither"
