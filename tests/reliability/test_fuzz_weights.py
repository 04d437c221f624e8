"""A few of the policies with absurd numbers; the script plays a thousand."""

from __future__ import annotations

from collections import Counter

import pytest

from reliability.fuzz_weights import FAST, check, end

pytestmark = pytest.mark.long

CASES = 24


def test_absurd_policies_get_an_answer_or_are_refused(street, tmp_path):
    ends = Counter(end(check(number, FAST, street, tmp_path)[1]) for number in range(CASES))
    assert set(ends) == {"answered", "refused while loading", "refused while playing"}
