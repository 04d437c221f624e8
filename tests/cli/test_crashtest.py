"""``jaxwalk crashtest``, as a user types it."""

from __future__ import annotations

import csv
import dataclasses
import json

import pytest

from jaxwalk.cli import main
from jaxwalk.cli.options import Crashtest

TESTS = """
name = "mine"
title = "My crash tests"
source = "me"
assumed = ["nothing <b>bold</b>"]
[variants.late]
start = 0.25
[[tests]]
name = "crossing"
title = "an adult crosses"
speeds = [20, 60]
meets = { x = 130.0 }
variants = ["late"]
passes = { impact = 0.0 }
[[tests.people]]
path = [[0.0, -4.0], [0.0, 6.0]]
hit = 50.0
[[tests]]
name = "nobody"
title = "an empty street"
speeds = [20]
meets = { x = 130.0 }
passes = { deceleration = 2.45, keeps = 0.8 }
"""


@pytest.fixture
def mine(place):
    (place / "mine.toml").write_text(TESTS)
    (place / "mine.xosc").write_text(TESTS)
    return place


@pytest.mark.long
def test_a_driver_is_tested(mine, capsys):
    """The careful human is late at 60 km/h; what is required decides the exit code."""
    words = ["crashtest", "careful-human", "--suite", "mine.toml", "--beside", "none", "--out", "there"]
    assert main([*words, "--require", "avoid<=20", "keep"]) == 0
    said = capsys.readouterr().out
    assert "careful-human: impact speed [km/h]; -: no contact; ~: left its lane" in said
    assert said.endswith("Open there/crashtest.html\n")
    assert main([*words, "--require", "pass", "keep"]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "careful-human falls short of pass in 1 run: crossing, 60 km/h: hit at 2" in said
    document = json.loads((mine / "there" / "crashtest.json").read_text())
    (driver,) = document["drivers"]
    assert [x["result"] for x in driver["outcomes"]] == ["avoided", "slowed", "kept"]
    assert [x["passed"] for x in driver["outcomes"]] == [True, False, True]
    assert "no official test, no score" in document["notice"]
    with (mine / "there" / "crashtest.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["speed"] for row in rows] == ["20.000", "60.000", "20.000"]
    page = (mine / "there" / "crashtest.html").read_text()
    assert page.count('data-episode="') - page.count('data-episode="${') == 3
    assert "nothing &lt;b&gt;bold&lt;/b&gt;" in page
    assert "avoids ✓" in page and "keeps ✓" in page and " ✗" in page


BAD = {
    "no driver": ("", "no driver: name one such as co-trained"),
    "no such driver": ("nobody", "nobody: no driver of that name"),
    "no such suite": ("careful-human --suite moon", "moon: no such suite of crash tests; use one of euro-ncap-style"),
    "no such file": ("careful-human --suite none.toml", "none.toml: cannot be read"),
    "no such scenario": ("careful-human --suite none.xosc", "none.xosc: can't be read (No such file or directory)"),
    "no scenario": ("careful-human --suite mine.xosc", "mine.xosc: not XML that can be read"),
    "no such layer": ("careful-human --suite mine.toml --layers early", "no such layer; choose from standard, late"),
    "no requirement": ("careful-human --suite mine.toml --require never", "--require never: can't be understood"),
    "about nothing": ("careful-human --suite mine.toml --require CPNA:keep", "no test of the suite is of that kind"),
    "beside": ("careful-human --suite mine.toml --beside nobody", "nobody: no driver of that name"),
    "time": ("careful-human --suite mine.toml --driver-seconds 0", "--driver-seconds must be above 0"),
}  # fmt: skip


@pytest.mark.parametrize(("words", "message"), BAD.values(), ids=BAD)
def test_what_cannot_be_used_ends_in_one_message(mine, capsys, words, message):
    assert main(["crashtest", *words.split()]) == 2
    assert message in " ".join(capsys.readouterr().err.split())
    assert not (mine / "runs" / "crashtest" / "crashtest.html").exists()


def test_help_says_every_default(capsys):
    assert main(["crashtest", "--help"]) == 0
    text = capsys.readouterr().out
    assert text.count("(default:") == len(dataclasses.fields(Crashtest))
