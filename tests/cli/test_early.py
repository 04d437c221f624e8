"""What can't be used is refused before JAX is imported, and files with a byte-order mark are read."""

from __future__ import annotations

import codecs
import json
import subprocess
import sys
from importlib import resources

import pytest

from jaxwalk.cli import main
from jaxwalk.maps import load_map
from jaxwalk.policies import DRIVERS, POPULATIONS
from jaxwalk.policies.policy_names import RULES
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.folder import Run

WRONG = {
    "evaluate --driver nobody": "nobody: no driver of that name",
    "evaluate --compare random nobody": "nobody: no driver of that name",
    "evaluate --driver random --pedestrians nobody": "nobody: no pedestrian of that name",
    "evaluate --driver random --pedestrians diffusion:0.5+nobody:0.5": "nobody: no pedestrian of that name",
    "play --driver random --pedestrians diffusion:0.5+always-go:0.4": "the shares are 0.9 together, not 1",
    "evaluate --driver random --map nowhere": "no such map",
    "evaluate --driver random --map half.toml": "half.toml has",
    "evaluate --driver none.onnx": "none.onnx: no such file",
    "evaluate --driver none.py:Mine": "none.py:Mine: no such file",
    "evaluate --driver empty": "empty: is no run folder",
    "evaluate --driver none.safetensors": "none.safetensors: no driver of that name",
    "play --driver nobody": "nobody: no driver of that name",
    "tracks --driver random --map half.toml": "half.toml has",
    "scenario --driver random --pedestrians nobody": "nobody: no pedestrian of that name",
    "frontier --driver clearance nobody": "nobody: no driver of that name",
    "frontier --pedestrians nobody": "nobody: no pedestrian of that name",
    "report --driver=random": "--driver: leave it out; drivers come first, as in: jaxwalk report co-trained clearance",
    "report --driver random": "--driver: leave it out; drivers come first, as in: jaxwalk report co-trained clearance",
    "evaluate --driver mine.py": "mine.py: name the class in it too, as in mine.py:MyDriver",
    "report nobody": "nobody: no driver of that name",
    "export nobody --out a.onnx": "nobody: no driver of that name",
    "share empty --out a.safetensors": "empty: is no run folder",
    "train --resume empty": "empty: is no run folder",
    "train --run new --map half.toml": "half.toml has",
    "train --run new --config none.toml": "none.toml: no such file",
    "train --run new --config half.toml": "half.toml: size: there is no such field",
    "sweep none.toml": "none.toml: no such file",
    "sweep half.toml": "half.toml: objective is missing",
    "map check half.toml": "half.toml has",
    "map draw nowhere": "no such map",
    "train --run full": "full: the folder is not empty",
    "evaluate --again none.json": "none.json: no such file",
    "measure none.parquet": "none.parquet: no such file",
    "evaluate --driver random --suite town --people 5": "--people: the suite town decides it; leave it out",
    "play --driver random --suite town --map paper": "--map: the suite town decides it; leave it out",
    "report random --suite crowd --world paper": "--world: the suite crowd decides it; leave it out",
    "scenario --driver random --people 0": "--people must lie in [1, 1,000], not 0",
    "tracks --driver random --people 1001": "--people must lie in [1, 1,000], not 1,001",
}
PROGRAM = """
import io, json, sys
from contextlib import redirect_stderr
from jaxwalk.cli import main
said = {}
for line in json.loads(sys.argv[1]):
    with redirect_stderr(io.StringIO()) as err:
        said[line] = main(line.split()), err.getvalue()
assert "jax" not in sys.modules
print(json.dumps(said))
"""


def test_names_and_files_are_checked_before_jax_is_imported(place):
    (place / "empty").mkdir()
    (place / "full").mkdir()
    (place / "full" / "notes.txt").write_text("mine")
    (place / "half.toml").write_text("size = [60, 20]\n")
    (place / "mine.py").write_text("class MyDriver: pass\n")
    command = [sys.executable, "-c", PROGRAM, json.dumps(list(WRONG))]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for line, (code, err) in json.loads(done.stdout).items():
        assert code == 2, line
        assert WRONG[line] in err and err.startswith("jaxwalk: "), line


def test_the_names_of_rules_are_those_of_the_policies():
    assert {"driver": tuple(DRIVERS), "pedestrian": tuple(POPULATIONS)} == RULES


def test_faults_of_a_map_are_one_a_line(place, capsys):
    (place / "half.toml").write_text("size = [60, 20]\n")
    assert main(["evaluate", "--driver", "random", "--map", "half.toml"]) == 2
    head, *faults = capsys.readouterr().err.splitlines()
    assert head == f"jaxwalk: map half.toml has {len(faults)} faults:"
    assert faults[0] == "  - car: missing; add it (docs: maps)"
    assert all(line.startswith("  - ") for line in faults)


def test_a_byte_order_mark_is_read(place):
    text = resources.files("jaxwalk.maps").joinpath("paper.toml").read_bytes()
    (place / "marked.toml").write_bytes(codecs.BOM_UTF8 + text)
    assert load_map(place / "marked.toml").width == load_map("paper").width
    run = Run.create(place / "run", RECIPES["fast"])
    path = run.path / "config.json"
    path.write_bytes(codecs.BOM_UTF8 + path.read_bytes())
    assert Run.open(run.path).experiment == run.experiment


@pytest.mark.parametrize("mark", [b"", codecs.BOM_UTF8])
def test_areas_may_have_a_byte_order_mark(mark, place):
    from jaxwalk.formats.areas import read_areas

    ring = [[0, 0], [9, 0], [9, 9], [0, 0]]
    road = {
        "type": "Feature",
        "properties": {"kind": "roadway"},
        "geometry": {"type": "Polygon", "coordinates": [ring]},
    }
    document = {"type": "FeatureCollection", "features": [road]}
    (place / "areas.geojson").write_bytes(mark + json.dumps(document).encode())
    assert read_areas(place / "areas.geojson").roadway.area > 0


def test_a_training_starts_without_what_it_does_not_need():
    """Statistics and metrics would take most of a second."""
    code = "import sys, jaxwalk.cli.train, jaxwalk.runs.entry; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "jaxwalk.learning.mappo" in loaded
    assert not {"scipy.stats", "scipy.sparse", "jaxwalk.metrics", "jaxwalk.evaluation.batches"} & {*loaded}


def test_options_are_read_without_geometry_or_arrays():
    code = "import sys, jaxwalk.cli.options; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "jaxwalk.maps.generated.splits" in loaded and not {"numpy", "shapely", "scipy", "jax"} & {*loaded}
