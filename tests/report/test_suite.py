"""The page of all metrics, and what it says of the speed differential."""

from __future__ import annotations

import pytest

from jaxwalk.evaluation import Cell, Results, ScenarioSet
from jaxwalk.metrics import Estimate, measure, summarise
from jaxwalk.metrics.speed_differential import Placebo, SpeedBin, SpeedGap
from jaxwalk.provenance import Provenance
from jaxwalk.report.suite import suite
from jaxwalk.report.surprise import FEWEST, four_ways, in_words
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, ghosts_of, trajectory
from report.material import REPLAYED

MADE = Provenance(commit="abc123", hardware="an abacus", versions={"jax": "0.10.2"})


def number(low: float | None, high: float | None, count: int = FEWEST) -> Estimate:
    value = None if low is None or high is None else (low + high) / 2
    return Estimate(value, low, high, count)


NONE, FASTER, SLOWER = number(-1.0, 1.0), number(0.5, 1.0), number(-1.0, -0.5)


def bins(raw: Estimate, beyond: Estimate, matched: Estimate) -> list[SpeedBin]:
    """A bin in which the three differences are so, and one in which nothing is known."""
    return [_bin(0.0, raw, beyond, matched), _bin(3.0, *[number(None, None)] * 3)]


def _bin(near: float, raw: Estimate, beyond: Estimate, matched: Estimate) -> SpeedBin:
    gap = SpeedGap(crosswalk=NONE, jaywalk=NONE, difference=raw)
    placebo = Placebo(people=gap, ghosts=gap, difference=beyond)
    return SpeedBin(near=near, far=near + 3, pooled=gap, by_encounter=gap, matched=matched, placebo=placebo)


@pytest.mark.parametrize(
    ("raw", "beyond", "matched", "said"),
    [
        (NONE, NONE, NONE, "jaywalkers and crosswalk users free of 0. Nor is there more than near ghosts"),
        (FASTER, NONE, NONE, "the car is faster at 0 to 3 m. No interval shows more than near ghosts"),
        (FASTER, FASTER, FASTER, "0 to 3 m. Beyond the difference near ghosts, which it cannot see, it is faster"),
        (FASTER, SLOWER, SLOWER, "is slower at 0 to 3 m. At nearly the same place and initial speed it is slower"),
        (NONE, FASTER, NONE, "At nearly the same place and initial speed no interval shows a difference."),
    ],
)  # fmt: skip
def test_what_the_four_say_together(raw, beyond, matched, said):
    assert said in in_words(bins(raw, beyond, matched))


def test_nothing_known_is_said_to_be_nothing_known():
    few = number(0.5, 1.0, FEWEST - 1)
    assert in_words(bins(few, FASTER, FASTER)[:1]) == "Too few people were near the car to say."


def test_five_rows_for_each_distance():
    rows = four_ways(bins(FASTER, NONE, SLOWER))
    assert [row[:2] for row in rows[:5]] == [
        ("0 to 3", name) for name in ("frames", "encounters", "matched", "ghosts", "people minus ghosts")
    ]
    assert rows[2][4:] == ("-0.75 [-1.00, -0.50]", "20 jaywalkers' encounters")
    assert rows[6][4] == "–"


@pytest.fixture(scope="module")
def page():
    people = [
        Walk(30.0, -4.0, vy=1.0, crossings=[(2, 40, CROSSWALK)]),
        Walk(40.0, 4.0, vy=-1.0, crossings=[(5, 45, JAYWALK)]),
    ]
    hit = Scene(50, [Walk(25.0, 0.0, crossings=[(20, 50, JAYWALK)]), people[0]], touched=[0])
    recorded = trajectory(Scene(50, people, goal=True), hit)
    summary = summarise(measure(recorded, ghosts_of(recorded)), resamples=20)
    mine = Cell("mine", "always-go", "mode", "sample", 0.25, summary, "route", "kerb", counterfactuals=REPLAYED)
    other = Cell("other", "always-go", "mode", "sample", 1.0, summary, "route", "kerb")
    return suite(Results(ScenarioSet(count=2, hash="0123456789abcdef", seed=5), (mine, other)), MADE)


def test_every_table_is_there_and_has_as_many_cells_as_columns(page):
    for heading in (
        "Outcomes",
        "At the kerb",
        "How it drives",
        "Contacts",
        "Encounters",
        "Contacts foretold by near misses",
        "Whose collisions",
        "Preventable",
        "Could it have been avoided?",
        "Would a careful human have avoided it?",
        "In words",
    ):
        assert f"\n## {heading}\n" in page
    tables = [part.splitlines() for part in page.split("\n\n") if part.startswith("| ")]
    assert len(tables) == 12
    for lines in tables:
        assert len({line.count(" | ") for line in lines}) == 1, lines[0]
        assert len(lines) >= 3
    assert "nan" not in page.lower()


def test_what_stands_in_it(page):
    assert "2 scenarios of seed 5 for every driver and population, hash 0123456789abcdef" in page
    assert "Made at commit abc123 on an abacus, jax 0.10.2." in page
    assert "| mine among always-go | 50.0 [1.3, 98.7] | 50.0 [1.3, 98.7] | 0.00 [0.00, 84.19] |" in page
    assert "| other among always-go x 1 |" in page
    # the car reaches who stands at 25 m with its front; the walkers cross after it, or before it comes
    assert "| mine among always-go | footprint | 50.0 [1.3, 98.7] | 50.0 [1.3, 98.7] | 1 | 0 | 1 | 0 | 0 |" in page
    by_pedestrian = (
        "| mine among always-go | jaywalk | 1 | 0.00 [0.00, 97.50] | 0.00 [0.00, 97.50] | 100.00 [2.50, 100.00]"
    )
    assert by_pedestrian in page
    said = "a careful human would have avoided 1 of 1 contact (100.00 [2.50, 100.00] %) from when the person was first"
    assert f"- mine among always-go: {said} seen, only an oracle 0, neither 0; from the start 0, 1 and 0" in page
    never = "0.00 [0.00, 97.50]"
    assert (
        f"| mine among always-go | all | 1 of 1 | 100.00 [2.50, 100.00] | {never} | {never} | 4.0 | {never} |" in page
    )
    assert (
        "| mine among always-go | 0 | – | 50.00 [1.26, 98.74] | – | cannot be extrapolated: few near misses |" in page
    )
    assert "| 14 and 16 | 5,006 |" in page
    assert "- **mine among always-go**: " in page
