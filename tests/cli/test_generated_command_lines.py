"""Generated command lines, most of them wrong; `tests/reliability/fuzz_loaders.py` plays many more."""

from __future__ import annotations

from hypothesis import HealthCheck, Phase, given, settings

from hostile.command_lines import command_lines, nothing_is_done, prepare
from hostile.judging import command, unfinished

CASES = 40


def test_a_command_line_ends_in_words(place):
    prepare(place)
    codes = []

    @settings(
        max_examples=CASES, deadline=None, derandomize=True, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(command_lines())
    def check(line):
        with nothing_is_done():
            codes.append(command(line)[0])

    check()
    assert codes.count(2) > CASES / 2, "most are wrong"
    assert not unfinished(place)
