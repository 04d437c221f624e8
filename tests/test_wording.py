from __future__ import annotations

from jaxwalk.evaluation import ScenarioSet
from jaxwalk.wording import counted


def test_one_is_singular_and_thousands_have_commas():
    assert [counted(n, "scenario") for n in (0, 1, 2, 2000)] == [
        "0 scenarios", "1 scenario", "2 scenarios", "2,000 scenarios",
    ]  # fmt: skip
    assert ScenarioSet(1, "", 3).name == "1 scenario of seed 3"
