"""Into how many parts an evaluation is divided, and which scenarios each has."""

from __future__ import annotations

import pytest

from jaxwalk.evaluation.document_parts import EvaluationOptions
from jaxwalk.evaluation.parts import Part, PartError
from jaxwalk.experiments.evaluating import Evaluation
from jaxwalk.experiments.kept_parts import number_of_parts
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.policies import AlwaysGo, ConstantSpeed
from jaxwalk.sim.environment import Street


@pytest.fixture(scope="module")
def street():
    return Street.create()


def work(street, episodes, *, multipliers=1):
    drivers, populations = {"constant-speed": ConstantSpeed()}, {"always-go": AlwaysGo()}
    options = EvaluationOptions((1.0,) * multipliers)
    return Evaluation((street,) * multipliers, drivers, populations, Scenarios(episodes, 0), options)


def test_a_part_has_about_8192_episodes_of_all_cells_and_there_are_sixteen_where_there_are_so_many_batches(street):
    assert number_of_parts(work(street, 5), None) == 1
    assert number_of_parts(work(street, 3 * 512), None) == 3
    assert number_of_parts(work(street, 30_000), None) == 16
    assert number_of_parts(work(street, 1_000_000), None) == 123  # 122.07 times 8,192
    assert number_of_parts(work(street, 1_000_000, multipliers=2), None) == 245
    assert number_of_parts(work(street, 1024, multipliers=100), None) == 2  # no more than batches


def test_another_number_is_taken_within_what_can_be_played_and_sent(street):
    assert number_of_parts(work(street, 1_000_000), 16) == 16
    with pytest.raises(PartError, match="a part plays at most 131,072 episodes in all its cells; take at least 8"):
        number_of_parts(work(street, 1_000_000), 7)
    with pytest.raises(PartError, match="1,536 episodes are 3 blocks of 512, so there are at most 3 parts"):
        number_of_parts(work(street, 1536), 4)
    assert number_of_parts(work(street, 512, multipliers=300), 1) == 1  # a batch can't be divided


def test_parts_divide_whole_batches():
    spans = [Part(number, 3).span(1900) for number in (1, 2, 3)]
    assert [(span.start, span.stop) for span in spans] == [(0, 512), (512, 1024), (1024, 1900)]
    assert Part(1, 1).span(5) == range(5)
    with pytest.raises(PartError, match="--part 1/5: 1,900 episodes are 4 blocks of 512, so there are at most 4"):
        Part(1, 5).span(1900)


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "", "-1/3", "1/0", "a/b", "1/3/5", "1.0/2", "٣/4"])
def test_a_part_is_a_number_of_a_number(text):
    with pytest.raises(PartError, match="must be K/N"):
        Part.parse(text)
    assert Part.parse("3/16") == Part(3, 16)
