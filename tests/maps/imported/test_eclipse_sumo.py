"""Streets of the networks and by the programs that come with the package eclipse-sumo, which CI installs."""

import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import shapely

from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.imported.importing import import_street, import_tiles, read_source, report_of
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.street_maker import DISTANCES
from maps.imported.drive_files import LANE, LENGTH, LOCAL, ON_ROAD, crosswalk, drive_file
from maps.imported.osm_files import cross

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(find_spec("sumo") is None, reason="needs the package eclipse-sumo"),
]
GAMES = {"fkk_in/ingolstadt.net.xml.gz": 11, "fokr_bs_demo/fokr_bs.net.xml.gz": 8}


@pytest.mark.parametrize("name, crossings", GAMES.items())
def test_networks_of_eclipse_sumo(name, crossings):
    path = Path(find_spec("sumo").submodule_search_locations[0]) / "tools/game" / name
    source = read_source(path)
    streets = import_tiles(source)
    found = report_of(source, streets, name, strict=False).crossings()
    placed = [outcome for outcome in found.values() if outcome.placed]
    assert len(source.crossings) == crossings and len(placed) >= 0.9 * len(found)
    assert sum(x.report.usable for x in streets) >= 0.7 * len(streets)
    for street in (x for x in streets if x.network is not None):
        assert network_faults(street.network, **DISTANCES) == []
        roadway = street.network.surface("roadway")
        assert all(roadway.buffer(0.05).covers(shapely.LineString(x.line)) for x in street.network.lanes)


def test_a_road_of_an_opendrive_file(tmp_path):
    path = tmp_path / "road.xodr"
    things = crosswalk(60) + crosswalk(120, t=-1.0, size="", outline=LOCAL) + crosswalk(0, size="", outline=ON_ROAD)
    path.write_text(drive_file(things), encoding="utf-8")
    source = read_source(path)
    assert sorted(tuple(x.point.round(2)) for x in source.crossings) == [(60, 50), (120, 50), (200, 50)]
    for crossing in source.crossings:
        assert crossing.kind == "zebra" and crossing.kind_origin == "mapped" and crossing.width == pytest.approx(4)
        np.testing.assert_allclose(np.abs(crossing.across), (0, 1), atol=1e-6)
    street = import_street(source, "road", strict=True)
    assert network_faults(street.network, **DISTANCES) == []
    assert street.report.verdict == "usable" and len(street.network.crossings) == 3
    assert source.attribution == "OpenDRIVE file road.xodr, which names no author"
    for lane in street.network.lanes:
        east = lane.line[-1, 0] > lane.line[0, 0]
        middle = street.network.size[1] / 2
        np.testing.assert_allclose(lane.line[:, 1], middle + (-1 if east else 1) * LANE / 2, atol=0.01)
        assert (lane.width, round(lane.speed_limit, 2)) == (LANE, 8.33) and lane.length() > LENGTH - 5


def test_an_opendrive_file_of_which_netconvert_makes_nothing(tmp_path):
    path = tmp_path / "road.xodr"
    for text in (drive_file("").replace('type="driving"', 'type="special9"'), drive_file("").replace("<line/>", "")):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(ImportRefusal) as refusal:
            read_source(path)
        said = str(refusal.value)
        assert said.startswith(f"{path}: ") and "\n" not in said and "/made" not in said


def test_the_gallery_is_made_of_what_is_installed(tmp_path):
    script = Path(__file__).parents[3] / "docs" / "street_gallery.py"
    command = [sys.executable, str(script), "--only", "fokr", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert [path.name for path in (tmp_path / "streets").iterdir()] == ["fokr-1.json"]
    assert "| fokr-1 | 4 signals | 0 | 100% | SUMO network" in (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "fokr: 1 of 1 wanted streets, of 1: 0 can't be used, and 0 have fewer mapped crossings" in done.stdout


@pytest.mark.parametrize("width", [3.2, 5.2])
def test_lanes_lie_where_netconvert_has_them(width, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[3] / "docs")
    check = import_module("lane_lines_check")
    monkeypatch.setattr(check, "WIDTH", width)
    cross().write(tmp_path / "cross.osm")
    distances, points = check.compared(check.of_equal_widths(tmp_path / "cross.osm", tmp_path))
    assert 100 < len(distances) < points and np.isfinite(distances).all()
    assert ((distances < 0.2).mean() > 0.95) == (width == 3.2), "netconvert's lanes are 3.2 m wide"
