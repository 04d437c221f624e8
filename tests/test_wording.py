from __future__ import annotations

from jaxwalk.evaluation import ScenarioSet
from jaxwalk.wording import counted, first_of


def test_one_is_singular_and_thousands_have_commas():
    assert [counted(n, "scenario") for n in (0, 1, 2, 2000)] == [
        "0 scenarios", "1 scenario", "2 scenarios", "2,000 scenarios",
    ]  # fmt: skip
    assert ScenarioSet(1, "", 3).name == "1 scenario of seed 3"


def test_long_lists_are_cut_off():
    assert [first_of(list("abcdefg")[:n], "map") for n in (1, 4, 5, 7)] == [
        "a", "a, b, c, d", "a, b, c, d and 1 more map", "a, b, c, d and 3 more maps",
    ]  # fmt: skip
