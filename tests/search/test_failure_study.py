"""What the study of docs/failure-search.md prints: every number of the page, here of searches made up by hand."""

from __future__ import annotations

import importlib.util
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "docs" / "failure_search_study.py"
PAGE = SCRIPT.with_name("failure-search.md")


def study():
    spec = importlib.util.spec_from_file_location("failure_search_study", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def search(method, seed, log, percentiles):
    counts = {"failures": 2 * log[-1], "cells": log[-1], "both": log[-1] - 1, "human": 1, "simulations": 2048}
    return {"method": method, "seed": seed, "log": log, "percentiles": percentiles, **counts}


def test_the_study_prints_the_page_s_table_its_ratio_and_the_oddest_failure():
    searches = [
        search("random", 0, [0, 1, 1, 2], [50.0, 7.0]),
        search("random", 1, [1, 1, 3, 4], [9.0]),
        search("map-elites", 0, [1, 2, 5, 8], [2.25, 80.0]),
        search("map-elites", 1, [2, 4, 9, 16], [3.0]),
    ]
    lines = study().summary(searches, ["random", "map-elites"], 2048).split("\n")
    assert lines[0] == (
        "| method | kinds after 512 scenarios | 1,024 | 2,048 | least to most | good "
        "| avoidable by the careful human, from when the person was seen | failures per 1,000 scenarios |"
    )
    assert lines[2] == "| `random` | 0.5 | 1.0 | 3.0 | 2 to 4 | 2.0 | 1.0 | 2.9 |"
    assert lines[3] == "| `map-elites` | 1.5 | 3.0 | 12.0 | 8 to 16 | 11.0 | 1.0 | 11.7 |"
    assert lines[4] == "map-elites: 4.0 times the kinds of random [4.0, 4.0] (bootstrap over 2 seeds, 95 %)"
    assert lines[5:] == [
        "random: percentile of the oddest failure: 7.00",
        "map-elites: percentile of the oddest failure: 2.25",
    ]


def test_the_page_has_the_study_s_table():
    head = study().summary([search("random", 0, [0] * 7 + [1], [5.0])], ["random"], 4096).split("\n")[0]
    assert head in PAGE.read_text(encoding="utf-8")
