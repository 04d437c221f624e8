"""What a reader sees first: exposure, limits, thresholds, what to watch, and what reverses of the paper's findings."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest

from browser.pages import gallery_document, watched
from jaxwalk.evaluation import Match, every_two
from jaxwalk.evaluation.document_parts import Interval, PolicyOrigin, StreetOrigin
from jaxwalk.evaluation.reading import Origin, as_results
from jaxwalk.maps import MapText
from jaxwalk.metrics import measure
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.first_screen import (
    WORST,
    driven_in,
    evidence_of,
    first_screen,
    speed_at_hits,
    to_watch,
    training_of,
)
from jaxwalk.report.reversals import Claim, apart, sentence, state
from jaxwalk.report.table import Table
from jaxwalk.report.table_files import as_data
from jaxwalk.report.validity import limits, thresholds
from jaxwalk.sim.sim_config import WORLDS
from metrics.scenes import trajectory
from report.material import SCENES, material


@pytest.fixture(scope="module")
def one():
    return material(1)


def test_every_two_drivers_are_compared_among_each_population(one):
    rows = measure(trajectory(*SCENES[5]))
    matches = [Match(cell, rows) for cell in one.results.cells]
    found = every_two(matches)
    drivers, populations = len(one.drivers), len(one.populations)
    assert len(found) == populations * drivers * (drivers - 1) // 2
    assert {(pair.ending, pair.training_seeds, pair.both, pair.only_a, pair.only_b) for pair in found} == {
        ("hit", 1, 1, 0, 0)
    }
    assert all(pair.a.pedestrians == pair.b.pedestrians for pair in found)
    results = dataclasses.replace(one.results, every_two=found)
    document = json.loads(results.to_json())
    assert as_results(document, Origin(Path("results.json"), "")).every_two == found


def test_the_evidence_is_that_of_the_cells(one):
    found = evidence_of(one)
    assert found.hits["co-trained", "learned"].value == pytest.approx(1 / 3)  # the car drives into who stands there
    assert found.goals["co-trained", "learned"].value == pytest.approx(2 / 3)
    assert (found.training, found.seeds) == ("one", 1)
    assert driven_in(one).encounters > 0


def test_of_several_seeds_hits_are_a_mean_without_an_interval():
    found = evidence_of(material(3))
    hits = found.hits["co-trained", "learned"]
    assert (hits.value, hits.low, hits.high) == (pytest.approx((1 + 2 + 3) / 9), None, None)
    assert (found.training, found.seeds) == ("few", 3)


def test_rules_alone_were_not_trained_and_of_python_it_is_not_known(one):
    def played(*kinds):
        origins = tuple(PolicyOrigin(kind, kind, None) for kind in kinds)
        anybody = dataclasses.replace(one, results=dataclasses.replace(one.results, drivers=origins))
        return training_of(anybody)

    assert [played("rule"), played("rule", "rule")] == ["none", "none"]
    assert [played("Python class"), played("rule", "Python class")] == ["unknown", "unknown"]
    assert [played("rule", "run folder"), played("Python class", "file")] == ["one", "one"]
    assert training_of(one) == "one"  # older results don't say


def test_the_worst_five_of_the_subject_come_first():
    gallery = watched(gallery_document())
    worst, of, count = to_watch(gallery, "rash")
    assert [(one.number, one.what) for one in worst] == [
        (0, "Hit at 5.0 m/s, 20 % risk of a serious injury"),
        (1, "Hit at 5.0 m/s, 10 % risk of a serious injury"),
        (2, "Near miss, 0.4 s to collision"),
    ]
    assert (of, count) == ("rash", 3)
    assert worst[0].address == "#episode=7&driver=rash&pedestrians=always-go&t=1.0"  # 3 s before it
    assert worst[0].who == "rash among always-go, scenario 7: jaywalker from the right, car going straight"
    everybody, of, count = to_watch(gallery, "nobody")
    assert ([one.number for one in everybody], of, count) == ([3, 0, 1, 2], "all drivers", 4)
    many = dataclasses.replace(gallery, incidents=gallery.incidents * 50)
    some, _, count = to_watch(many, "rash")
    assert (len(some), count) == (WORST, 150)
    assert to_watch(None, "rash") == ((), "", 0)


def test_the_speed_at_hits_is_that_of_the_worlds_rule(one):
    def found(rule):
        street = StreetOrigin((), dataclasses.replace(WORLDS["paper"], contact=rule))
        return speed_at_hits(
            dataclasses.replace(one, results=dataclasses.replace(one.results, street=street)), "co-trained", "learned"
        )

    contacts = one.cell("co-trained", "learned").summary[MEASURED_CONTACTS]
    assert found("disc") == Interval.of(contacts.disc.car_speed) == Interval(5.0, None, None)
    assert found("footprint") == Interval.of(contacts.footprint.car_speed)
    unknown = dataclasses.replace(one, results=dataclasses.replace(one.results, street=None))
    assert speed_at_hits(unknown, "co-trained", "learned").value is None


def test_exposure_limits_and_thresholds_follow_the_world(one):
    def screen(world):
        street = StreetOrigin((MapText("paper", "0123456789abcdef"),), WORLDS[world])
        return first_screen(dataclasses.replace(one, results=dataclasses.replace(one.results, street=street)))

    paper, hiding = screen("paper"), screen("blind-corner")
    exposure = {said.name: said.text for said in paper.exposure}
    assert exposure["Scenarios"] == "3 for each of 7 drivers among always-go, learned"
    assert (exposure["Streets"], exposure["People"]) == ("1: paper", "12 in each scenario")
    assert exposure["Populations"] == "always-go never wait for the car; learned have learned when to wait"
    assert paper.hit == "disc: centres closer than 1.5 m"
    words = {said.name: said.text for said in paper.thresholds}
    assert words["Hit"].startswith("a collision of the car at 0.5 m/s or more;")
    assert words["Collision"] == "a contact that ends the scenario: centres closer than 1.5 m"
    assert "a body (0.25 m) overlaps the car (4.5 x 1.8 m)" in {x.name: x.text for x in hiding.thresholds}["Collision"]
    senses = [{said.name: said.text for said in found.limits}["Senses"] for found in (paper, hiding)]
    assert senses[0].startswith("Everybody is seen at once and without error")
    assert "within 60 m is seen at once and without error" in senses[1]
    late = dataclasses.replace(WORLDS["blind-corner"], delay=0.3, misses=0.1)
    assert "seen 0.3 s late, missed in 10 % of steps" in " ".join(said.text for said in limits(late))
    assert [said.name for said in thresholds(None)] == ["Collision", "Hit", "Encounter", "Near miss", "Sure", "Too few"]


def test_what_reverses_is_one_sentence():
    found = (
        Claim("the car is faster near jaywalkers", "slower", "reverses"),
        Claim("more jaywalking means more collisions", "fewer", "holds"),
        Claim("training together helps", "it does not", "open"),
    )
    assert sentence(found) == (
        "Of 3 directions that the paper reports, 1 reverses: the car is faster near jaywalkers (here slower); 1 holds: "
        "more jaywalking means more collisions; 1 is open: training together helps."
    )
    assert sentence(found[1:2]) == (
        "Of 1 direction that the paper reports, none reverses; 1 holds: more jaywalking means more collisions."
    )
    assert sentence(()) == ""


@pytest.mark.parametrize(
    ("low", "high", "sign", "said"),
    [(0.1, 0.3, 1, "holds"), (0.1, 0.3, -1, "reverses"), (-0.3, -0.1, -1, "holds"), (-0.1, 0.1, 1, "open"),
     (None, None, 1, "open")],
)  # fmt: skip
def test_a_direction_is_that_of_the_interval(low, high, sign, said):
    assert state(Interval(0.0, low, high), 0.0, sign=sign) == said


def test_two_numbers_lie_apart_if_their_intervals_do():
    low, high, wide = Interval(1.0, 0.0, 2.0), Interval(4.0, 3.0, 5.0), Interval(2.0, 1.0, 4.0)
    assert [apart(low, high), apart(high, low), apart(low, wide), apart(low, Interval(1.0, None, None))] == [
        "holds", "reverses", "open", "open",
    ]  # fmt: skip


def test_a_table_for_programs_has_numbers():
    table = Table(
        ("driver", "n", "share %", "ratio"), (("7", "1,234", "1.0 [0.5, 2.0]", "> 2.1"), ("b", "–", "3", "1"))
    )
    found = as_data(table, "What it is.")
    assert found["rows"] == [
        ["7", 1234.0, {"value": 1.0, "low": 0.5, "high": 2.0}, "> 2.1"], ["b", None, 3.0, "1"],
    ]  # fmt: skip
    assert (found["caption"], found["columns"]) == ("What it is.", ["driver", "n", "share %", "ratio"])
