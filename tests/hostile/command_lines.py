"""Command lines of which most can't be: every command's own options, with values that make sense or not."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from hypothesis import strategies as st
from safetensors.numpy import save

from hostile.targets import ARRAYS, HEADER
from jaxwalk.cli import options
from jaxwalk.cli.commands import COMMANDS
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.folder import Run
from jaxwalk.runs.street import make_street
from scenarios.small_archive import write_small_archive
from sweeps.tiny_sweep import written

WORKERS = (
    "jaxwalk.runs.entry.train_in", "jaxwalk.runs.study.train_in", "jaxwalk.runs.study.Work._do",
    "jaxwalk.experiments.evaluating.evaluate_grid",
    "jaxwalk.cli.play._page", "jaxwalk.cli.play._drawing", "jaxwalk.experiments.driver_report.play_rounds",
    "jaxwalk.exports.sharing.evaluate_grid", "jaxwalk.cli.tracks.record_tracks", "jaxwalk.cli.scenario.export_scenario",
    "jaxwalk.exports.onnx_policy.met", "jaxwalk.cli.bench.benchmark", "jaxwalk.cli.bench.planned",
    "jaxwalk.maps.generated.town_street.make_street", "jaxwalk.cli.crashtest.run_crash_tests",
    "jaxwalk.cli.search.search_failures", "jaxwalk.cli.search.estimate_rate",
    "jaxwalk.cli.evaluation_asked.read_archive",
    "jaxwalk.cli.importing_streets.read_source",
    "jaxwalk.cli.launcher._train",
    "jaxwalk.cli.rate.make_rating", "jaxwalk.cli.rate.analyse_answers", "jaxwalk.cli.live.serve_pages",
    "jaxwalk.cli.sweep.sweep", "jaxwalk.cli.sweep.submit_jobs", "jaxwalk.cli.sweep.run_on_ray",
    "jaxwalk.cli.submit.read_entry", "jaxwalk.cli.merge.merge_parts", "jaxwalk.cli.evaluate.evaluate_part",
    "jaxwalk.cli.evaluate.evaluate_on_cluster",
    "jaxwalk.cli.map_new.write_whole", "jaxwalk.cli.map_check.load_network", "jaxwalk.cli.map_draw.street_picture",
)  # fmt: skip
"""Where the work begins that a good command line asks for: a case ends there."""
PEOPLE = ["always-go", "learned", "mine.safetensors", "run", "nobody", "bad.safetensors"]
DRIVERS = [
    "random", "co-trained", "mine.safetensors", "route-follower", "oracle", "run", "half", "bad.safetensors",
    "nonsense.onnx", "nonsense.zip", "nonsense.pt", "nowhere:Mine", "idle.py:Idle", "nobody",
]  # fmt: skip
OUTS = [
    "out.html", "out.png", "out.mp4", "out.onnx", "out.safetensors", "out.parquet", "new", "new/deep/er", "file",
    "file/below", "run", ".", "x" * 300,
]  # fmt: skip
STRANGE = [
    "",
    "-",
    "--",
    "\udcff",
    "\u202e\U0001f697",
    "<script>",
    "[red]",
    "{0}",
    "../..",
    "None",
    "True",
    "fast",
    "3",
]
NUMBERS = ["1", "2", "3", "0", "-1", "2147483647", "2147483648", "9" * 30, "0.5", "1e308", "1e999", "nan", "-inf", "٣"]
LIKELY = {
    "driver": DRIVERS, "drivers": DRIVERS, "beside": DRIVERS, "runs": DRIVERS, "policy": DRIVERS, "compare": DRIVERS,
    "pedestrians": PEOPLE, "out": OUTS,
    "run_folder": ["new", *OUTS], "resume": ["run", "half", "file"], "map": ["paper", "town.toml", "nowhere"],
    "file": ["new.toml", "new.json", "cross.osm", *OUTS], "like": ["paper", "test:3", "nowhere"],
    "config": ["town.toml", "file"], "recipe": ["fast", "paper"],
    "files": ["tracks.parquet", "tracks.csv", "a_traj_ped_filtered.csv"],
    "role": ["driver", "pedestrian"], "only": ["env", "train"], "areas": ["file", "nowhere"],
    "method": ["random", "map-elites", "splitting"], "scenarios": ["file", "nowhere", "run"],
    "suite": ["paper", "r152", "town.toml"], "require": ["avoid<=40", "keep", "never"], "layers": ["standard", "all"],
    "answers": ["file", "nowhere"], "archive": ["file", "nowhere", "run", "found.safetensors"],
    "part": ["1/3", "3/3", "4/3"], "parts": ["run", "file", "nowhere", "3"],
    "study": ["study.toml", "town.toml", "file", "nowhere"], "on": ["local", "slurm", "ray"],
    "cluster": ["local", "auto", "ray://host:1", "nowhere"],
}  # fmt: skip
"""By the name of an option; all others take numbers, or nothing."""
POSITIONAL = ("study", "runs", "policy", "files", "drivers", "file")
NAMELESS = ((options.MapCheck, "map"), (options.MapDraw, "map"), (options.Merge, "parts"))
"""What has no flag in one command, and a flag in another."""


def commands() -> list[type]:
    """The classes of all commands."""
    return [command.options for command in COMMANDS]


@st.composite
def command_lines(draw: Callable[[st.SearchStrategy[Any]], Any]) -> list[str]:
    """A command with some of its options, each with as many values as anybody likes."""
    kind = draw(st.sampled_from(commands()))
    name = next(command.name for command in COMMANDS if command.options is kind)
    fields = {field.name: field for field in dataclasses.fields(kind)}
    given = [field for field in fields if field in LIKELY and draw(st.booleans())]
    given += draw(st.lists(st.sampled_from(sorted(fields)), max_size=3))
    line = [name]
    for field in given:
        bare = field in POSITIONAL or (kind, field) in NAMELESS
        if not bare and not (kind is options.Share and field == "run_folder"):
            line.append("--" + ("run" if field == "run_folder" else field.replace("_", "-")))
        if fields[field].default is not False:
            values = st.sampled_from(LIKELY.get(field, NUMBERS) * 5 + STRANGE)
            line += draw(st.lists(values, min_size=1, max_size=2 if "tuple" in str(fields[field].type) else 1))
    spoiled = draw(st.sampled_from(["no"] * 20 + ["insert", "drop"]))
    if spoiled != "no":
        at = draw(st.integers(0, len(line) - 1))
        line[at : at + 1] = [draw(st.sampled_from(STRANGE))] if spoiled == "insert" else []
    return line


def prepare(folder: Path) -> None:
    """What the words name: some good, some not."""
    Run.create(folder / "run", RECIPES["fast"])
    (folder / "half").mkdir()
    (folder / "half" / "config.json").write_text("{}")
    (folder / "mine.safetensors").write_bytes(save(ARRAYS, {"jaxwalk": json.dumps(HEADER)}))
    (folder / "bad.safetensors").write_bytes(save({"x": np.zeros(1)}, {"jaxwalk": "{}"}))
    write_small_archive(folder / "found.safetensors", make_street(RECIPES["fast"]))
    written(folder)
    (folder / "idle.py").write_text("class Idle: pass\n")
    (folder / "town.toml").write_text("size = [60, 20]\n")
    for name in ("cross.osm", "nonsense.onnx", "nonsense.zip", "nonsense.pt", "file", "tracks.parquet"):
        (folder / name).write_bytes(b"nonsense")


@contextmanager
def nothing_is_done() -> Iterator[None]:
    """Meanwhile a command ends with success where its work would begin."""
    with ExitStack() as stack:
        for worker in WORKERS:
            stack.enter_context(mock.patch(worker, side_effect=SystemExit(0)))
        yield
