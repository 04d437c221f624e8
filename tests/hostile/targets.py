"""Everything that jaxwalk reads: a good file, ways to spoil it, and the reader that must refuse it in words."""

from __future__ import annotations

import json
import tempfile
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from safetensors.numpy import save

from hostile.drivers import agent, onnx_network, spoiled_agent, spoiled_archive, spoiled_onnx, torchscript_network
from hostile.mutations import Files, as_json, as_toml, damaged, documents
from jaxwalk.cli.train import bad_values
from jaxwalk.formats.areas import read_areas
from jaxwalk.formats.layouts import open_tracks
from jaxwalk.formats.measured import measure_all
from jaxwalk.maps import load_map
from jaxwalk.policies import load_policy, read_metadata
from jaxwalk.policies.host import load_host_driver
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.folder import Run
from jaxwalk.runs.street import make_street
from jaxwalk.runs.watch import curves
from jaxwalk.sim.sim_config import SimConfig


@dataclass(frozen=True)
class Target:
    """One kind of input."""

    files: Files
    """A good one."""
    read: Callable[[Path], Any]
    """What is done with the folder of files."""
    hostile: st.SearchStrategy[Files]
    """Bad ones (a few stay good)."""


def play(target: Target, files: Files) -> Any:
    """Read these files."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            (Path(folder) / name).write_bytes(content)
        return target.read(Path(folder))


def rewritten(name: str, good: Any, write: Callable[[Any], bytes]) -> st.SearchStrategy[Files]:
    """A single file that holds a spoiled document."""
    return documents(good).map(lambda document: {name: write(document)})


def _map() -> Target:
    text = resources.files("jaxwalk.maps").joinpath("paper.toml").read_bytes()
    files = {"town.toml": text}
    spoiled = rewritten("town.toml", tomllib.loads(text.decode()), as_toml)
    return Target(files, lambda folder: load_map(folder / "town.toml"), spoiled | damaged(files))


def _run() -> Target:
    """The configuration of a run folder, as far as the first array."""
    with tempfile.TemporaryDirectory() as folder:
        content = Run.create(Path(folder) / "run", RECIPES["fast"]).path.joinpath("config.json").read_bytes()
    files = {"config.json": content}
    spoiled = rewritten("config.json", json.loads(content), as_json)
    return Target(files, lambda folder: make_street(Run.open(folder).experiment), spoiled | damaged(files))


def _kept_maps() -> Target:
    """The maps that a run folder keeps."""
    with tempfile.TemporaryDirectory() as folder:
        run = Run.create(Path(folder) / "run", RECIPES["fast"])
        files = {name: (run.path / name).read_bytes() for name in ("config.json", "maps.json")}
    spoiled = rewritten("maps.json", json.loads(files["maps.json"]), as_json).map(lambda changed: {**files, **changed})
    return Target(files, lambda folder: Run.open(folder).maps(), spoiled | damaged(files))


def _metrics() -> Target:
    line = {"update": 1, "seconds": 1.5, "steps": 64, "episodes": 3, "goal_rate": 0.5, "driver/kl": 0.01}
    lines = [{**line, "update": n} for n in range(1, 6)]
    files = {"metrics.jsonl": b"".join(as_json(x) + b"\n" for x in lines)}

    def read(folder: Path) -> None:
        run = Run(folder, RECIPES["fast"])
        run.keep_metrics(3)
        curves(run.metrics())

    spoiled = documents(lines).map(lambda x: {"metrics.jsonl": b"".join(as_json(y) + b"\n" for y in x)})
    return Target(files, read, spoiled | damaged(files))


ARRAYS = {
    "driver.layer0.weight": np.zeros((4, 59), np.float32), "driver.layer0.bias": np.zeros(4, np.float32),
    "driver.layer1.weight": np.zeros((2, 4), np.float32), "driver.layer1.bias": np.zeros(2, np.float32),
    "driver.log_std": np.zeros(2, np.float32),
    "pedestrian.layer0.weight": np.zeros((2, 31), np.float32), "pedestrian.layer0.bias": np.zeros(2, np.float32),
}  # fmt: skip
HEADER = {
    "format": 1,
    "roles": {
        "driver": {"observes": "route", "kind": "clipped", "sizes": [59, 4, 2], "hold": 1},
        "pedestrian": {"observes": "kerb", "kind": "gated", "sizes": [31, 2], "hold": 10},
    },
    "metadata": {"recipe": "fast", "seed": 0, "steps": 100},
}
KINDS = ["float16", "float64", "int32", "bool", "uint8", "int64"]


@st.composite
def _policies(draw: Callable) -> Files:
    """A safetensors file that is one, with other arrays, and with another header of ours."""
    arrays = dict(ARRAYS)
    if draw(st.booleans()):
        name = draw(st.sampled_from(sorted(arrays)))
        spoil = draw(st.sampled_from([
            lambda x: x.T, lambda x: x[:1], lambda x: x[None], lambda x: np.full_like(x, np.nan),
            lambda x: np.zeros((0,), np.float32), *(lambda x, kind=kind: x.astype(kind) for kind in KINDS),
        ]))  # fmt: skip
        arrays[name] = np.ascontiguousarray(spoil(arrays[name]))
        if draw(st.booleans()):
            arrays[draw(st.sampled_from(["driver.", "thief.layer0.weight", "driver.layer-1.bias"]))] = arrays.pop(name)
    header = draw(documents(HEADER) | st.just(HEADER))
    return {"mine.safetensors": save(arrays, {"jaxwalk": as_json(header).decode("utf-8", "replace")})}


def _policy() -> Target:
    files = {"mine.safetensors": save(ARRAYS, {"jaxwalk": json.dumps(HEADER)})}

    def read(folder: Path) -> None:
        read_metadata(folder / "mine.safetensors")
        load_policy(folder / "mine.safetensors", "pedestrian", expect_size=31)
        load_policy(folder / "mine.safetensors", "driver", expect_size=59)

    return Target(files, read, _policies() | damaged(files) | _raw_safetensors(files["mine.safetensors"]))


def _raw_safetensors(good: bytes) -> st.SearchStrategy[Files]:
    """Another length of the header, other offsets, shapes and types of its arrays."""
    length = int.from_bytes(good[:8], "little")
    header = json.loads(good[8 : 8 + length])

    def write(spoiled: Any) -> bytes:
        text = as_json(spoiled)
        return len(text).to_bytes(8, "little") + text + good[8 + length :]

    claimed = st.sampled_from([0, 1, length - 1, 10**8, 2**40, 2**63, 2**64 - 1])
    lengths = claimed.map(lambda n: {"mine.safetensors": n.to_bytes(8, "little") + good[8:]})
    return rewritten("mine.safetensors", header, write) | lengths


STREET = {
    "type": "FeatureCollection",
    "features": [
        {
            "type": "Feature",
            "properties": {"kind": kind},
            "geometry": {"type": "Polygon", "coordinates": [[[0, -4], [200, -4], [200, 4], [0, 4], [0, -4]]]},
        }
        for kind in ("roadway", "crosswalk")
    ],
}


def _areas() -> Target:
    files = {"areas.geojson": as_json(STREET)}
    spoiled = rewritten("areas.geojson", STREET, as_json)
    return Target(files, lambda folder: read_areas(folder / "areas.geojson"), spoiled | damaged(files))


def _measured(name: str) -> Callable[[Path], Any]:
    """Opening a file of trajectories and measuring them, as `jaxwalk measure` does."""

    def read(folder: Path) -> Any:
        source = open_tracks(folder / name, frame_rate=25.0)
        with bad_values():
            config = SimConfig(**source.rules)
        return measure_all(((x, source.areas) for x in source.recordings), config=config).as_dict()

    return read


def _parquet() -> Target:
    """A table of trajectories as Parquet: wrong bytes, or a wrong table in a sound file."""
    import pyarrow
    from pyarrow.parquet import write_table

    frames, about = range(30), {"schema": 1, "dt": 0.1}
    good = {
        "episode": [0] * 60, "t": [0.1 * n for n in frames] * 2, "id": [0] * 30 + [1] * 30,
        "type": ["car"] * 30 + ["pedestrian"] * 30, "x": [0.8 * n for n in frames] + [20.0] * 30,
        "y": [0.0] * 30 + [0.1 * n for n in frames], "vx": [8.0] * 30 + [0.0] * 30, "vy": [0.0] * 30 + [1.0] * 30,
        "heading": [0.0] * 60, "length": [4.5] * 60, "width": [1.8] * 60, "crossing": ["none"] * 60,
    }  # fmt: skip

    def write(table: Any, told: Any = about, areas: Any = STREET) -> bytes | None:
        content = pyarrow.BufferOutputStream()
        try:
            made = pyarrow.table({str(name): column for name, column in table.items()})
            write_table(
                made.replace_schema_metadata({"jaxwalk": as_json(told), "jaxwalk_areas": as_json(areas)}), content
            )
        except (pyarrow.ArrowException, ArithmeticError, AttributeError, TypeError, ValueError):
            return None  # it can't even be made
        return content.getvalue().to_pybytes()

    def files(content: bytes | None) -> dict[str, bytes]:
        return {} if content is None else {"tracks.parquet": content}

    spoiled = st.one_of(
        documents(good).map(write),
        documents(about).map(lambda told: write(good, told)),
        documents(STREET).map(lambda areas: write(good, about, areas)),
    )
    sound = files(write(good))
    return Target(sound, _measured("tracks.parquet"), spoiled.map(files) | damaged(sound))


def _csv(head: str, rows: list[list[Any]]) -> bytes:
    return "\n".join([head, *(",".join(map(str, row)) for row in rows)]).encode("utf-8", "replace")


def _tables(tables: Mapping[str, tuple[str, list[list[Any]]]]) -> st.SearchStrategy[Files]:
    """Of CSV files, other values in one."""
    good = {name: _csv(*table) for name, table in tables.items()}
    return st.sampled_from(sorted(tables)).flatmap(
        lambda name: documents(tables[name][1]).map(
            lambda rows: {**good, name: _csv(tables[name][0], [x if isinstance(x, list) else [x] for x in rows])}
        )
    )


def _ind() -> Target:
    frames = range(60)
    rows = [[0, n, 100.0, 0.3 * n - 45, 90.0, 1.9, 4.6, 0.0, 8.0] for n in frames]
    rows += [[1, n, 100.0, 0.1 * n, 0.0, 0.0, 0.0, 0.0, 0.1] for n in frames]
    tables = {
        "07_tracks.csv": ("trackId,frame,xCenter,yCenter,heading,width,length,xVelocity,yVelocity", rows),
        "07_tracksMeta.csv": ("trackId,class", [[0, "car"], [1, "pedestrian"]]),
        "07_recordingMeta.csv": ("recordingId,frameRate", [[7, 25]]),
    }
    files = {name: _csv(*table) for name, table in tables.items()}
    return Target(files, _measured("07_tracks.csv"), _tables(tables) | damaged(files))


def _vci() -> Target:
    tables = {
        "a_traj_ped_filtered.csv": (
            "id,frame,label,x_est,y_est,vx_est,vy_est",
            [[0, n, "ped", 20.0, 0.1 * n, 0.0, 1.0] for n in range(40)],
        ),
        "a_traj_veh_filtered.csv": (
            "id,frame,label,x_est,y_est,psi_est,vel_est",
            [[0, n, "veh", 0.3 * n, 1.0, 0.0, 8.0] for n in range(40)],
        ),
    }
    files = {name: _csv(*table) for name, table in tables.items()}
    return Target(files, _measured("a_traj_ped_filtered.csv"), _tables(tables) | damaged(files))


def _driver(name: str, good: bytes, spoiled: st.SearchStrategy[bytes | None]) -> Target:
    """A network of another framework."""
    cases = spoiled.map(lambda content: {} if content is None else {name: content})
    return Target({name: good}, lambda folder: load_host_driver(str(folder / name)), cases | damaged({name: good}))


def _onnx() -> Target:
    return _driver("driver.onnx", good := onnx_network(), spoiled_onnx(good))


def _torchscript() -> Target:
    return _driver("driver.pt", good := torchscript_network(), spoiled_archive(good))


def _agent() -> Target:
    return _driver("driver.zip", good := agent(), spoiled_agent(good))


MAKERS: dict[str, Callable[[], Target]] = {
    "map": _map, "configuration": _run, "kept maps": _kept_maps, "metrics": _metrics, "policy": _policy,
    "areas": _areas, "inD": _ind, "DUT": _vci, "Parquet": _parquet,
    "driver.onnx": _onnx, "driver.pt": _torchscript, "driver.zip": _agent,
}  # fmt: skip
"""What makes them, by name."""
NEEDS = {"Parquet": "pyarrow", "driver.onnx": "onnxruntime", "driver.pt": "torch", "driver.zip": "torch"}
"""The packages without which some can't be read."""


def make_targets() -> dict[str, Target]:
    """All that can be read here, by name."""
    return {name: make() for name, make in MAKERS.items() if name not in NEEDS or find_spec(NEEDS[name])}
