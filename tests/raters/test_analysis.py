"""What is said of raters whose preferences are known, and what of files that are no answers."""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from jaxwalk.evaluation.reading import DocumentError
from jaxwalk.raters import AnswersError, RatingError, analyse, answers_page, read_answers, read_plan
from jaxwalk.raters.answer_words import headline
from jaxwalk.raters.answers_analysis import count
from raters.simulated import a_plan, files, measure

sys.path.insert(0, str(Path(__file__).parents[1] / "reliability"))
from simulated_raters import COVERED, LEAST_TAU, simulate

STRONG = np.array([3.0, 2.0, 1.0, 0.0, -1.0, -2.0, -3.0])
MEASURES = (
    measure("hits", [1, 2, 3, 4, 5, 6, 7], high=False), measure("backwards", [1, 2, 3, 4, 5, 6, 7]),
    measure("alike", [1] * 7),
)  # fmt: skip


@pytest.fixture(scope="module")
def plan():
    return a_plan(measures=MEASURES)


def rng():
    return np.random.default_rng(5)


def test_a_slice_of_the_simulation():
    found = simulate(4, resamples=200)
    assert found.tau > 0.8
    assert found.coverage > 0.85
    assert set(found.agreements) <= {"partial", "firm"}


@pytest.mark.long
def test_a_hundred_simulations():
    found = simulate(100)
    assert found.tau >= LEAST_TAU
    assert COVERED[0] <= found.coverage <= COVERED[1]


def test_known_preferences_are_found(plan):
    found = analyse(plan, files(plan, STRONG, 20, rng()), resamples=200)
    assert [one.driver for one in found.drivers][:2] == ["driver-0", "driver-1"]
    assert (found.raters, found.answers, found.inattentive) == (20, 500, ())
    assert sum(one.compared for one in found.drivers) == 1000  # each answer is about two
    assert found.agreement in ("partial", "firm")
    lead = found.drivers[0].strength.value - found.drivers[1].strength.value
    assert found.lead.value == pytest.approx(lead)
    assert found.lead.low < lead < found.lead.high
    hits, backwards, alike = found.measures
    assert hits.tau.value == -backwards.tau.value > 0.8
    assert hits.tau.low <= hits.tau.value <= hits.tau.high
    assert (alike.tau.value, alike.drivers) == (None, 7)
    assert found.repeated[1] == 60
    assert "raters find driver-0 safer than driver-1" in headline(found) or "put driver-0 first" in headline(found)
    text = answers_page(plan, found)
    assert "| driver-0 | " in text and "Krippendorff's alpha" in text and "Which car drove more safely?" in text


def test_raters_who_disagree_are_said_to(plan):
    """Half of them see it the other way round; or nobody has a preference."""
    divided = np.where(np.arange(20)[:, None] < 10, STRONG, -STRONG)
    for strengths in (divided, np.zeros(7)):
        found = analyse(plan, files(plan, strengths, 20, rng()), resamples=200)
        assert found.agreement == "chance"
        assert headline(found) == "The raters disagree: which driver people find safer cannot be said."
        assert "do not surely agree more than by chance" in answers_page(plan, found)


def test_a_minority_is_counted(plan):
    divided = np.where(np.arange(20)[:, None] < 17, STRONG, -STRONG)
    found = analyse(plan, files(plan, divided, 20, rng()), resamples=200)
    assert found.against == 3
    assert "3 raters contradict this order in most answers." in answers_page(plan, found)


def test_who_does_not_attend_is_left_out(plan):
    good, bad = files(plan, STRONG, 6, rng()), files(plan, -STRONG, 2, rng(), attentive=False)
    found = analyse(plan, [*good, *bad], resamples=50)
    assert (found.raters, set(found.inattentive)) == (6, {one.rater for one in bad})
    assert "2 more failed a check and are left out" in answers_page(plan, found)
    with pytest.raises(ValueError, match="no rater who passed the checks"):
        analyse(plan, bad)


def test_four_raters_are_too_few(plan):
    found = analyse(plan, files(plan, STRONG, 4, rng()), resamples=50)
    assert {one.strength.low for one in found.drivers} == {None}
    assert found.alpha.low is None
    assert headline(found).startswith("Which driver people find safer cannot be judged: 4 raters passed the checks")


def test_sides_and_order_do_not_matter(plan):
    one = files(plan, STRONG, 1, rng())[0]
    turned = dataclasses.replace(
        one,
        answers=tuple(
            dataclasses.replace(
                x, left="b" if x.left == "a" else "a",
                answer={"left": "right", "right": "left", "equal": "equal"}[x.answer],
            )
            for x in one.answers[::-1]
        ),
    )  # fmt: skip
    assert (count(plan, [one]) == count(plan, [turned])).all()
    assert count(plan, [one]).sum() == plan.each


def _content(plan):
    return dataclasses.asdict(files(plan, STRONG, 1, rng())[0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"plan": "another"}, "answers the page of another plan"),
        ({"schema": 2}, "another version"),
        ({"rater": "<script>"}, "not 16 hexadecimal digits"),
        ({"consent": False}, "did not say to be 18 or older and to consent"),
        ({"name": "Ann"}, "damaged .name"),
        ({"answers": None}, "damaged .answers"),
        ({"answers": [{"pair": 0}]}, "damaged .answers.0"),
        (
            {"answers": [{"pair": 10**9, "left": "a", "answer": "left", "seconds": 1.0, "repeat": False}]},
            "answers pair",
        ),
        (
            {"answers": [{"pair": -1, "left": "a", "answer": "left", "seconds": 1.0, "repeat": False}]},
            "answers pair -1",
        ),
        ({"answers": [{"pair": 1, "left": "a", "answer": "left", "seconds": -1.0, "repeat": False}]}, "no time"),
        ({"answers": [{"pair": 1, "left": "a", "answer": "left", "seconds": 1.0, "repeat": True}]}, "twice"),
        ({"answers": [{"pair": 1, "left": "a", "answer": "left", "seconds": 1.0, "repeat": False}] * 2}, "twice"),
        ({"answers": [{"pair": 1, "left": "c", "answer": "left", "seconds": 1.0, "repeat": False}]}, "answers.0.left"),
    ],
)
def test_hostile_answers_are_refused(plan, tmp_path, change, message):
    path = tmp_path / "answers.json"
    path.write_text(json.dumps({**_content(plan), **change}))
    with pytest.raises((AnswersError, DocumentError), match=message) as error:
        read_answers([path], plan)
    assert str(error.value).startswith(f"{path}: ")
    assert str(error.value).count("\n") == 0


@pytest.mark.parametrize("text", ["", "[]", "nonsense", "[" * 100_000, '{"a": NaN}', "\udcff", "null", " " * 1_000_001])
def test_files_that_are_no_answers_are_refused(plan, tmp_path, text):
    path = tmp_path / "answers.json"
    path.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises((AnswersError, DocumentError), match=r"answers\.json: "):
        read_answers([path], plan)


def test_two_files_of_one_rater_are_refused(plan, tmp_path):
    for name in ("a.json", "b.json"):
        (tmp_path / name).write_text(json.dumps(_content(plan)))
    assert len(read_answers([tmp_path / "a.json"], plan)) == 1
    with pytest.raises(AnswersError, match=r"b\.json: is of the same rater as .*a\.json"):
        read_answers([tmp_path / "a.json", tmp_path / "b.json"], plan)


def test_a_plan_is_read_back_unless_it_was_changed(plan, tmp_path):
    path = tmp_path / "plan.json"
    with pytest.raises(RatingError, match="no such file"):
        read_plan(path)
    path.write_text(json.dumps(plan.as_dict()))
    assert read_plan(path) == plan
    path.write_text(json.dumps({**plan.as_dict(), "each": 3}))
    with pytest.raises(RatingError, match="was changed"):
        read_plan(path)
    path.write_text(json.dumps({**plan.as_dict(), "drivers": ["one"]}))
    with pytest.raises(DocumentError, match="has 1 drivers"):
        read_plan(path)
    path.write_text("[]")
    with pytest.raises(DocumentError, match="damaged"):
        read_plan(path)
