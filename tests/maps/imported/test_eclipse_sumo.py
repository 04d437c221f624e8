"""Streets of the networks that come with the package eclipse-sumo, which CI installs."""

from importlib.util import find_spec
from pathlib import Path

import pytest
import shapely

from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.imported.importing import import_tiles, read_source, report_of
from jaxwalk.maps.imported.street_maker import DISTANCES

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
