"""The script of docs/real-streets.md that measures imports, on a small map."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from maps.imported.lanelet_maps import road_map

pytestmark = pytest.mark.long
SCRIPT = Path(__file__).parents[3] / "docs" / "real_streets_study.py"


def test_the_study_measures_files(tmp_path):
    (tmp_path / "road.osm").write_text(road_map().text(), encoding="utf-8")
    (tmp_path / "none.osm").write_text('<osm version="0.6"></osm>', encoding="utf-8")
    command = [sys.executable, str(SCRIPT), str(tmp_path / "road.osm"), str(tmp_path / "none.osm"), "--episodes", "8"]
    done = subprocess.run([*command, "--out", str(tmp_path / "out")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    road, none = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))["files"]
    numbers = {name: road[name] for name in ("crossings", "placed", "tiles", "usable", "episodes", "connected_after")}
    assert numbers == {"crossings": 1, "placed": 1, "tiles": 2, "usable": 2, "episodes": 16, "connected_after": 1.0}
    assert (
        0 < road["seconds"] < 120
        and 50 < road["peak_MB"] < 2000
        and road["frames_on_roadways"] > 0 == road["off_crosswalks"]
        and set(road["by_tile"]) == {"tile-001.json", "tile-002.json"}
    )
    assert "none.osm: has no roads" in none["refused"]
    page = (tmp_path / "out" / "results.md").read_text(encoding="utf-8")
    assert "| road.osm | 1 of 1 | " in page and "| none.osm | jaxwalk: " in page
