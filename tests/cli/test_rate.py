"""``jaxwalk rate``, as a user types it."""

from __future__ import annotations

import json

import pytest

from jaxwalk.cli import main
from jaxwalk.raters import read_plan
from raters.simulated import a_plan, files


@pytest.mark.long
def test_a_page_is_made_and_its_answers_are_analysed(place, capsys):
    command = "rate clearance careful-human route-follower --episodes 64 --pairs 3 --out there"
    assert main(command.split()) == 0
    said = capsys.readouterr().out
    assert said == (
        "Send raters there/rate.html; when they have sent their files: jaxwalk rate --out there --answers FILES\n"
    )
    plan = read_plan(place / "there" / "plan.json")
    assert plan.drivers == plan.players == ("clearance", "careful-human", "route-follower")
    assert len(plan.rated) == 9
    page = (place / "there" / "rate.html").read_text(encoding="utf-8")
    assert "careful-human" not in page
    hits = plan.measures[0]
    assert hits.values[0] < hits.values[2]


@pytest.fixture
def answers(place):
    """A folder with a plan, and the files of six raters."""
    import numpy as np

    plan = a_plan(3, each=9)
    (place / "there").mkdir()
    (place / "there" / "plan.json").write_text(json.dumps(plan.as_dict()))
    from dataclasses import asdict

    for number, one in enumerate(files(plan, np.array([3.0, 0.0, -3.0]), 6, np.random.default_rng(0))):
        (place / f"answers-{number}.json").write_text(json.dumps(asdict(one)))
    return [f"answers-{number}.json" for number in range(6)]


def test_answers_are_analysed(place, answers, capsys):
    assert main(["rate", "--out", "there", "--answers", *answers]) == 0
    said = capsys.readouterr().out
    assert "raters" in said and said.endswith("Read there/ratings.md\n")
    found = json.loads((place / "there" / "ratings.json").read_text())
    assert (found["raters"], found["answers"]) == (6, 54)
    assert found["drivers"][0]["driver"] == "driver-0"
    assert (place / "there" / "ratings.md").read_text().startswith("# What raters say\n")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--out there --answers nowhere.json", "nowhere.json: no such file; check the name"),
        ("--out elsewhere --answers answers-0.json", "elsewhere/plan.json: no such file; name the folder"),
        (
            "--pairs 5 --out there --answers answers-0.json",
            "--pairs: --answers analyses what there/plan.json says; leave it out",
        ),
        (
            "clearance oracle --out there --answers answers-0.json",
            "drivers: --answers analyses what there/plan.json says",
        ),
        ("--out there --answers answers-0.json answers-0.json", "is of the same rater as answers-0.json"),
        ("--out there --answers there/plan.json", "there/plan.json: damaged"),
        ("clearance random --out there", "--out there: answers to the page there need its plan.json"),
        ("clearance", "2 to 20 different drivers can be rated, not 1"),
        ("clearance clearance", "2 to 20 different drivers can be rated, not 1"),
        ("clearance random --pairs 2", "--pairs must lie in [3, 200], not 2"),
        ("clearance random --episodes 0", "--episodes must lie in"),
        ("clearance nobody", "nobody"),
    ],
)
def test_what_cannot_be_is_one_message(place, answers, words, message, capsys):
    assert main(["rate", *words.split()]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert message in said
    assert said.count("jaxwalk: ") == 1
    assert not (place / "runs").exists() and not (place / "elsewhere").exists()


@pytest.mark.long
def test_too_few_scenarios_are_said(place, capsys):
    assert main(["rate", "clearance", "careful-human", "--episodes", "3", "--pairs", "3", "--out", "there"]) == 2
    assert "take more --episodes" in " ".join(capsys.readouterr().err.split())
    assert not (place / "there" / "rate.html").exists()
