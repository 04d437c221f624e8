"""``jaxwalk streets``, as a user types it."""

from __future__ import annotations

import pytest
from PIL import Image

from jaxwalk.cli import main
from jaxwalk.maps.generated import TOWN


def test_streets_are_listed_and_drawn(place, capsys):
    assert main(["streets", "--split", "test", "--count", "2", "--out", "there"]) == 0
    said = capsys.readouterr().out
    assert f"test, family {TOWN.hash}" in said and "2000000000" in said and "2000000001" in said
    assert said.endswith("there: 2 pictures, and streets.png with all of them\n")
    names = ["2000000000.png", "2000000001.png", "streets.png"]
    assert sorted(path.name for path in (place / "there").iterdir()) == names
    for name in names:
        with Image.open(place / "there" / name) as picture:
            assert max(picture.size) > 500 and len(picture.convert("RGB").getcolors(10**6)) > 20


def test_numbers_without_a_street_are_counted(place, capsys):
    assert main(["streets", "--first", "71", "--count", "2"]) == 0
    said = capsys.readouterr().out
    assert " 71 " in said and " 72 " not in said and " 73 " in said
    assert "1 number refused:\n  1 x roads meet beyond their junctions" in said
    assert not list(place.iterdir())


def test_numbers_are_checked(capsys):
    assert main(["streets", "--first", "70", "--check", "4"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == f"training: 4 numbers from 70 on, family {TOWN.hash}"
    assert said[1:3] == ["3 accepted (75.0%), 1 refused", "  1 x roads meet beyond their junctions"]
    assert said[3].endswith(" ms)")


BAD = {
    "no such split": ("--split moon", "invalid choice 'moon'"),
    "none": ("--count 0", "--count must lie in [1, 200], not 0"),
    "too many": ("--count 201", "--count must lie in [1, 200], not 201"),
    "no check": ("--check 0", "--check must lie in [1, 1,000,000], not 0"),
    "before the first": ("--first -1", "--first must lie in [0, 999,999,999], not -1"),
    "past the last": ("--split test --first 1000000", "--first must lie in [0, 999,999], not 1,000,000"),
    "past the last check": ("--split test --first 999990 --check 11", "--check must lie in [1, 10], not 11"),
    "check draws nothing": ("--check 3 --out there", "--check draws nothing"),
    "a file": ("--out notes.txt", "notes.txt is a file"),
}


@pytest.mark.parametrize("words, message", BAD.values(), ids=BAD)
def test_what_cannot_be_used_ends_in_one_message(place, capsys, words, message):
    (place / "notes.txt").write_text("x")
    assert main(["streets", *words.split()]) == 2
    assert message in " ".join(capsys.readouterr().err.split())
    assert [path.name for path in place.iterdir()] == ["notes.txt"]


def test_a_disk_that_fills_leaves_no_picture(place, monkeypatch):
    monkeypatch.setattr("jaxwalk.cli.streets.contact_sheet", _full)
    assert main(["streets", "--count", "1", "--out", "there"]) == 2
    assert not list((place / "there").iterdir())


def _full(*_):
    raise OSError(28, "No space left on device", "streets.png")
