"""``jaxwalk map``, as a user types it."""

from __future__ import annotations

import pytest
from PIL import Image

from jaxwalk.cli import main
from jaxwalk.maps import load_network


def test_a_new_map_is_sound_and_can_be_played_on(place, capsys):
    assert main(["map", "new", "mine.toml", "--length", "150", "--width", "7", "--crosswalks", "40", "110"]) == 0
    assert main(["map", "check", "mine.toml", "paper"]) == 0
    written, mine, paper = capsys.readouterr().out.splitlines()
    assert written == "mine.toml: a street with 2 crosswalks; edit it, then: jaxwalk map check mine.toml"
    assert mine.startswith("mine.toml: no faults; 150 x 19 m, 2 lanes, 2 routes, 2 crossings, 2 of them with a jaywalk")
    assert paper.startswith("paper: no faults; 120 x 120 m")
    zones = [crossing.zone for crossing in load_network("mine.toml").crossings]
    assert [(zone.begin, zone.end) for zone in zones] == [(3, 27), (3, 27)]
    assert main(["play", "--driver", "route-follower", "--map", "mine.toml", "--out", "seen.png"]) == 0


@pytest.mark.parametrize(
    "words", ["", "--length 40", "--length 1000 --crosswalks 10 22 990", "--width 5", "--width 14"]
)
def test_extreme_streets_are_sound(words, place):
    assert main(["map", "new", "deep/er/mine.toml", *words.split()]) == 0
    assert main(["map", "check", "deep/er/mine.toml"]) == 0


@pytest.mark.parametrize(("like", "file"), [("paper", "mine.toml"), ("test-2000000003", "mine.json")])
def test_a_copy_is_the_same_street(like, file, place):
    assert main(["map", "new", file, "--like", like]) == 0
    assert load_network(file).size == load_network(like).size


@pytest.mark.parametrize(
    ("words", "name"),
    [("paper", "paper.png"), ("mine.toml", "mine.png"), ("paper --out deep/er/x.svg", "deep/er/x.svg")],
)
def test_a_map_is_drawn(words, name, place, capsys):
    assert main(["map", "new", "mine.toml"]) == 0
    assert main(["map", "draw", *words.split()]) == 0
    assert f"{name}: " in capsys.readouterr().out
    if name.endswith(".png"):
        with Image.open(place / name) as picture:
            assert max(picture.size) > 500 and len(picture.convert("RGB").getcolors(10**6)) > 20


BAD = {
    "there already": ("new there.toml", "there.toml: is already there; name another file"),
    "another ending": ("new mine.txt", "mine.txt: the name must end in .toml"),
    "a network": ("new mine.toml --like test-2000000003", "mine.toml: the name must end in .json"),
    "no such map": ("new mine.toml --like nowhere", "no such map"),
    "several": ("new mine.json --like test:3", "stands for several streets"),
    "too short": ("new mine.toml --length 39", "--length must lie in [40, 1000] m, not 39"),
    "no number": ("new mine.toml --width nan", "--width must lie in [5, 14] m, not nan"),
    "too near": ("new mine.toml --crosswalks 40 51", "crosswalks must rise by 12 m or more and keep 10 m"),
    "at the end": ("new mine.toml --crosswalks 91", "keep 10 m from both ends"),
    "infinite": ("new mine.toml --crosswalks inf", "--crosswalks must be finite numbers"),
    "a copy as it is": ("new mine.toml --like paper --length 90", "--like: a copy has its own length"),
    "nothing": ("check", "name a map"),
    "faults": ("check there.toml", "there.toml has 6 faults"),
    "no picture": ("draw paper --out paper.txt", "--out paper.txt: the name must end in one of .png, .svg, .pdf"),
    "a folder": ("draw paper --out folder.png", "--out folder.png: is a folder"),
    "below a file": ("draw paper --out there.toml/x.png", "there.toml is a file"),
    "no such word": ("sketch paper", "Unrecognized options"),
}


@pytest.mark.parametrize("words, message", BAD.values(), ids=BAD)
def test_what_cannot_be_used_ends_in_one_message(words, message, place, capsys):
    (place / "there.toml").write_text("size = [60, 20]\n")
    (place / "folder.png").mkdir()
    assert main(["map", *words.split()]) == 2
    assert message in " ".join(capsys.readouterr().err.split())
    assert sorted(path.name for path in place.iterdir()) == ["folder.png", "there.toml"]


def test_a_python_runs_the_command_too(place):
    """``python -m jaxwalk``, where no script is on the path."""
    import subprocess
    import sys

    done = subprocess.run([sys.executable, "-m", "jaxwalk", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("jaxwalk ")
