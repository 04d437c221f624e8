"""Speeds on few and on many streets: the programs take turns."""

from __future__ import annotations

from dataclasses import replace

import pytest

from jaxwalk.bench.benchmark_settings import QUICK, Settings
from jaxwalk.bench.streets import simulated, take_turns


def test_programs_take_turns_after_each_has_compiled():
    called = []

    def program(name):
        def turn():
            called.append(name)
            return float(len(called))

        return turn

    assert take_turns({"a": program("a"), "b": program("b")}, 2) == {"a": [3.0, 5.0], "b": [4.0, 6.0]}
    assert called == ["a", "b"] * 3


@pytest.mark.long
def test_streets_are_played_in_turns():
    few = replace(Settings(**QUICK), street_environments=2, steps=2, turn_seconds=0.01)
    rows = simulated(few)
    asked = [("every", 1), ("every", 2), ("no rays", 1), ("no rays", 2)]
    assert [(row["observations"], row["streets"]) for row in rows] == asked
    assert all(len(row["env_steps_per_s"]) == few.turns for row in rows)
    assert all(0 <= speed < 1e9 for row in rows for speed in row["env_steps_per_s"])
    assert rows[1]["bytes_per_street"] < 5e6  # what a street of 200 x 200 m may take
