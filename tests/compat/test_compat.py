"""Version 0.1's scenarios come out again; a slice of `compare.py`: so do its outcomes, and its files can be used."""

from __future__ import annotations

import pytest

from compat.compare import RECORDED, TRAINED, compare, differences, different_outcomes
from compat.record import read
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.runs.folder import Run
from jaxwalk.scenarios import Drawn


@pytest.mark.parametrize(("seed", "episodes", "multiplier", "digest"), read(RECORDED / "scenarios.json.gz"))
def test_scenarios_are_those_of_version_0_1(street, seed, episodes, multiplier, digest):
    assert Drawn(with_jaywalk_multiplier(street, multiplier), seed, episodes).hash() == digest


@pytest.mark.long
@pytest.mark.parametrize("part", ["scenarios", "evaluations", "updates", "trained"])
def test_it_behaves_as_version_0_1(part, tmp_path):
    found = list(compare([part], quick=True, folder=tmp_path))
    assert found
    assert [f"{x.what}: {x.differs}" for x in found if x.differs] == []


def test_a_configuration_of_0_1_is_read():
    train = Run.open(TRAINED).experiment.train
    assert list(train.roles) == ["driver", "pedestrian"]
    assert train.roles["pedestrian"].hold == 10
    assert train.environments == 12


def test_a_difference_is_seen():
    before = {"rate": {"value": 0.25, "low": None}, "count": [3, 4000], "name": "a", "driver_ms_per_step": 1.0}
    same = {"rate": {"value": 0.25005, "low": None}, "count": [3, 4000.1], "name": "a", "added": 1}
    assert differences(before, same, 1e-4) == []
    assert differences(before, {**same, "count": [3, 4001]}, 1e-4) == [".count[1] is 4001, not 4000"]
    assert differences(before, {**same, "count": [3]}, 1e-4) == [".count has 1 entries, not 2"]
    assert differences(before, {**same, "rate": {"value": 0.2502}}, 1e-4) == [
        ".rate.low is missing", ".rate.value is 0.2502, not 0.25",
    ]  # fmt: skip
    assert differences(before, {**same, "rate": None}, 1e-4) == [f".rate is None, not {before['rate']}"]


def test_one_outcome_may_differ():
    assert different_outcomes("gct" * 10, "gct" * 10) == ("", 0)
    assert different_outcomes("gct" * 10, "gcc" + "gct" * 9) == ("", 1)
    assert different_outcomes("gct" * 10, "ccc" + "gct" * 9) == ("2 of 30 outcomes, first in scenario 0", 2)
    assert different_outcomes("gct", "gc")[0] == "2 outcomes, not 3"
