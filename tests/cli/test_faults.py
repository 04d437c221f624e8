"""A slice of `tests/reliability/faults.py`, and what its table must have."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import pytest

from jaxwalk.cli.commands import COMMANDS as TABLE
from reliability.fault_table import COMMANDS, FAULTS
from reliability.faults import AT_LEAST, cases, play, wrong

PAGE = Path(__file__).parents[2] / "docs" / "testing.md"
SLICE = ("JAX_NUM_CPU_DEVICES=0", "LC_ALL=C in ASCII", "all closed", "full messages", "an empty PATH", "COLUMNS=1")


def test_every_fault_meets_commands_enough_and_every_command_meets_faults():
    met = [(fault.name, command) for fault, command in cases(False, "")]
    assert len(FAULTS) >= 40 and len({fault.name for fault in FAULTS}) == len(FAULTS)
    assert min(Counter(name for name, _ in met).values()) >= AT_LEAST
    assert {command for _, command in met} == set(COMMANDS) == {command.name for command in TABLE}


def test_the_page_lists_every_fault():
    text = PAGE.read_text(encoding="utf-8")
    assert [fault.name for fault in FAULTS if f"| {fault.name} |" not in text] == []


@pytest.mark.parametrize("name", SLICE)
def test_a_fault_ends_as_promised(name, place):
    fault = next(fault for fault in FAULTS if fault.name == name)
    seen = play(fault, "observations", place, Path(os.environ["JAX_COMPILATION_CACHE_DIR"]))
    assert wrong(fault, "observations", seen, place, slack=5) == []


@pytest.mark.parametrize("code", [0, 3])
def test_what_is_not_as_promised_is_noticed(code, place):
    """A line for the shell that does what a broken command would."""
    from reliability.faults import Seen

    fault = FAULTS[0]
    (place / "kept").mkdir()
    (place / "kept" / ".results.7.part.json").write_text("{")
    (place / "kept" / "results.json").write_text("new")
    (place / "kept" / "suite.md").write_text("older")
    found = wrong(fault, "evaluate", Seen(code, "jaxwalk: a\njaxwalk: b\nTraceback", 1.0), place, slack=1)
    assert [what.split(":")[0] for what in found] == [
        f"exit code {code}, not one of (2,)", "'Traceback' on standard error", "2 messages", "half-written",
        "older files beside new ones",
    ]  # fmt: skip
