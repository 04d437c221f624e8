"""Command lines of pages with small numbers, and what they read: so that all of them can be run."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from glob import glob
from itertools import pairwise
from pathlib import Path

from jaxwalk.cli import main
from jaxwalk.raters.rating_plan import read_plan
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.street import make_street
from jaxwalk.scenarios.archive_file import SCENARIOS
from maps.imported.osm_files import cross
from raters.simulated import write_files
from scenarios.small_archive import write_small_archive
from sweeps.tiny_sweep import written as write_sweep

SMALL = {
    "--episodes": "4", "--counterfactuals": "1", "--incidents": "1", "--updates": "2", "--count": "1", "--check": "2",
    "--people": "6", "--simulations": "4096",
}  # fmt: skip
"""Options that decide how long a command takes, with small values."""
EPISODES = ("evaluate", "report", "tracks", "share")
CHECKED = (
    "train", "reproduce", "hidden-intent", "co-training", "generalisation", "risk-aware", "frontier", "crashtest",
    "bench", "live", "submit", "sweep",
)  # fmt: skip
"""Commands that can't be made short: they run up to where their work begins, which has tests of its own."""
ELSEWHERE = ("driver.pt", "ppo.zip", "theirs.parquet", "07_tracks.csv", "clip_traj_ped_filtered.csv")
"""Files that can't be made here: agents of PyTorch (`tests/policies/host` has some), other people's recordings."""
DRIVER = "class {name}:\n    def act(self, observation):\n        return 0 * observation[:, :2]\n"
MODULE = re.compile(r"^([\w/]+)(?:\.py)?:([A-Z]\w*)")


def briefly(words: list[str]) -> list[str]:
    """Return a command's words with small numbers in place of large ones."""
    words = words[: words.index(">")] if ">" in words else list(words)
    for at, (word, value) in enumerate(pairwise(words), 1):
        if word in SMALL and not value.startswith("--"):
            words[at] = SMALL[word]
    words = [re.sub(r"^([a-z-]+):\d+$", r"\1:1", word) for word in words]
    if words[1] == "train" and "--recipe" in words and "--map" not in words:
        words += ["--map", "training:1"]
    if "--scenario" in words:
        words = _only_the_first(words, words.index("--scenario") + 1)
    if "splitting" in words:
        words += ["--particles", "64", "--repeats", "2"]
    if words[1] in EPISODES and not {"--episodes", "--again", "--scenarios"} & set(words):
        words += ["--episodes", "4"]
    return words


def _only_the_first(words: list[str], at: int) -> list[str]:
    """Return words with one number at a place: how many scenarios a brief search finds depends on rounding."""
    end = next((each for each in range(at, len(words)) if not words[each].isdecimal()), len(words))
    return words[: at + 1] + words[end:]


def fewer_streets(file: str) -> str:
    """Return the file of a training or a suite with one street in place of many: they take long to make."""
    return re.sub(r'^(maps = \["[a-z-]+):\d+', r"\1:1", file, flags=re.MULTILINE)


def as_a_shell_does(words: list[str]) -> list[str]:
    """Replace patterns by the names of files that match them."""
    return [name for word in words for name in (sorted(glob(word)) if "*" in word else [word])]


def written(words: list[str]) -> set[str]:
    """Return the folders and files that a command writes."""
    return {word for before, word in pairwise(words) if before in ("--out", "--run")}


def provide(words: list[str], trained: Path) -> None:
    """Make what a command reads and nobody has made: run folders, drivers of one's own, exported ones."""
    outs = written(words)
    for word in set(words) - outs:
        path = Path(word)
        if word.startswith("runs/") and not path.exists():
            shutil.copytree(trained, path)
        elif found := MODULE.match(word):
            _write_driver(Path(f"{found[1]}.py"), found[2])
        elif word.startswith("zoo/"):
            path.mkdir(parents=True, exist_ok=True)
        elif word == "study.toml" and not path.exists():
            write_sweep(Path())
        elif word == "town.osm":
            cross().write(path)
        elif word == "answers-*.json":
            write_files(Path(), read_plan(Path(words[words.index("--out") + 1]) / "plan.json"), raters=5)
        elif word in ("driver.onnx", "first.safetensors") and not path.exists():
            line = f"export co-trained --out {word}" if word == "driver.onnx" else f"share runs/first --out {word}"
            assert main(line.split()) == 0
    if "--archive" in words:
        _write_archive(Path(words[words.index("--archive") + 1]), words)
    if "train" in words:
        clear(outs)


def _write_archive(folder: Path, words: list[str]) -> None:
    """Write scenarios that the training of a command can mix in, as a search on its street would."""
    shutil.rmtree(folder, ignore_errors=True)
    recipe = RECIPES[words[words.index("--recipe") + 1] if "--recipe" in words else "fast"]
    maps = (words[words.index("--map") + 1],) if "--map" in words else recipe.maps
    write_small_archive(folder / SCENARIOS, make_street(replace(recipe, maps=maps)))


def _write_driver(file: Path, name: str) -> None:
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(DRIVER.format(name=name))


def clear(folders: set[str]) -> None:
    """Remove what a training was to fill; the next command that reads it gets the tiny training."""
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)
