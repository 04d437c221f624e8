"""Generated files, most of them wrong: whatever is read is taken, or refused in words. Never a traceback or a hang.

`tests/reliability/fuzz_loaders.py` does the same with thousands of them.
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from hostile.judging import refused
from hostile.targets import MAKERS, NEEDS, play

CASES = 15
few = settings(
    max_examples=CASES, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)  # fmt: skip


@pytest.fixture(scope="module", params=MAKERS)
def target(request):
    """Made when a test asks for it: it takes a while, and packages that may not be there."""
    if request.param in NEEDS:
        pytest.importorskip(NEEDS[request.param])
    return MAKERS[request.param]()


def test_a_good_file_is_taken(target):
    assert refused(lambda: play(target, target.files)) is None


def test_a_bad_file_is_refused_in_words(target):
    messages = []

    @few
    @given(target.hostile)
    def check(files):
        messages.append(refused(lambda: play(target, files)))

    check()
    told = [message for message in messages if message]
    assert len(told) > CASES / 4, "most are wrong"
    assert any(name in message for message in told for name in target.files), "the file is named"
