"""Shields on the command line: an option, or a part of a driver's name."""

from __future__ import annotations

import json

import pytest

from jaxwalk.cli import main


def test_drivers_are_shielded_by_an_option_or_by_their_names(place, capsys):
    """And the document says so: it can be made again."""
    found = {}
    for asked in ("random --shield predictive", "random+predictive"):
        assert main(f"evaluate --driver {asked} --episodes 3 --seed 7 --out kept --json".split()) == 0
        found[asked] = json.loads(capsys.readouterr().out)
    first, second = found.values()
    assert first == second
    assert [cell["driver"] for cell in first["cells"]] == ["random+predictive"]
    assert first["cells"][0]["driver_mode"] == "sample"
    assert main(["evaluate", "--again", "kept/results.json"]) == 0


@pytest.mark.long
def test_a_driver_beside_itself_behind_a_shield_says_what_the_shield_changes(place, capsys):
    assert (
        main(["evaluate", "--driver", "random", "random+rss", "--episodes", "3", "--seed", "7", "--out", "kept"]) == 0
    )
    (one,) = json.loads((place / "kept" / "results.json").read_text())["shields"]
    assert (one["driver"], one["shield"], one["scenarios"]) == ("random", "rss", 3)
    assert one["in_words"] in capsys.readouterr().out.replace("\n", "")
    assert one["in_words"] in (place / "kept" / "suite.md").read_text()
    assert main(["evaluate", "--again", "kept/results.json"]) == 0
