"""A disk without room, or one that may only be read: one message, exit code 2, and nothing half-written."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from jaxwalk import writing
from jaxwalk.cli import main
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.folder import Run
from maps.imported.osm_files import cross
from sweeps.tiny_sweep import written

COMMANDS = {
    "train": "train --run out",
    "sweep": "sweep study.toml --out out",
    "play": "play --driver constant-speed --out out/episode.html",
    "evaluate": "evaluate --driver constant-speed --episodes 2 --out out",
    "a part": "evaluate --driver constant-speed --episodes 2 --part 1/1 --out out",
    "rate": "rate constant-speed route-follower --episodes 32 --pairs 3 --out out",
    "reproduce": "reproduce --out out",
    "hidden-intent": "hidden-intent --out out",
    "co-training": "co-training --out out",
    "generalisation": "generalisation --out out",
    "risk-aware": "risk-aware --out out",
    "frontier": "frontier --out out",
    "search": "search constant-speed --simulations 1 --minimise 0 --out out",
    "import": "import cross.osm --out out",
    "map new": "map new out/a.toml",
    "map draw": "map draw paper --out out/a.png",
}
"""As they are given; each writes into out. What else writes uses the same `whole`."""
FAULTS = {errno.ENOSPC: "No space left on device; make room", errno.EROFS: "Read-only file system; name another place"}


LONG = ("a part", "rate", "search")
"""What plays the most."""


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.long] * (x in LONG)) for x in COMMANDS])
def test_no_room_is_one_message_and_nothing_is_half_written(name, place, capsys, monkeypatch):
    fault = list(FAULTS)[list(COMMANDS).index(name) % len(FAULTS)]

    def fail(_):
        raise OSError(fault, os.strerror(fault))

    cross().write(place / "cross.osm")
    written(place)
    monkeypatch.setattr(writing, "_to_disk", fail)
    assert main(COMMANDS[name].split()) == 2
    err = " ".join(capsys.readouterr().err.split())
    assert FAULTS[fault] in err
    assert err.count("jaxwalk: ") == 1
    assert "jaxwalk: out/" in err
    assert [path.name for path in (place / "out").rglob("*") if path.name != ".lock"] == []


def test_a_folder_that_may_only_be_read_is_refused_before_anything_is_done(place, capsys, monkeypatch):
    Run.create(place / "run", RECIPES["fast"])
    written(place)
    monkeypatch.setattr(os, "access", lambda *_: False)  # the superuser may write everywhere
    for command in (*COMMANDS.values(), "train --resume run"):
        assert main(command.split()) == 2, command
        assert "no permission to write to" in capsys.readouterr().err
    assert not (place / "out").exists()


def test_a_disk_that_fills_up_on_the_way_leaves_an_older_evaluation_as_it_was(place, capsys, monkeypatch):
    """`results.json` is the last file to be written."""
    (place / "out").mkdir()
    for name in ("results.json", "suite.md", "episodes.csv"):
        (place / "out" / name).write_text("older")
    to_disk = writing._to_disk

    def fail(path):
        if "results" in path.name:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        to_disk(path)

    monkeypatch.setattr(writing, "_to_disk", fail)
    assert main(COMMANDS["evaluate"].split()) == 2
    assert "jaxwalk: out/results.json: No space left on device" in capsys.readouterr().err
    left = {path.name: path.read_text() for path in (place / "out").iterdir() if path.name != ".lock"}
    assert left == {"results.json": "older", "suite.md": "older", "episodes.csv": "older"}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_what_is_printed_to_a_full_disk_is_told_of():
    command = [sys.executable, "-m", "jaxwalk", "observations"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "jaxwalk: No space left on device; make room on the disk, or name another place\n"
