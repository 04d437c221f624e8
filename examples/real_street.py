"""A street of the real world: a few lines of OpenStreetMap become a street with a report, and two drivers try it."""

from pathlib import Path
from tempfile import TemporaryDirectory

from jaxwalk import DRIVERS, Drawn, Street
from jaxwalk.evaluation import evaluate
from jaxwalk.maps.imported.importing import import_street, read_source
from jaxwalk.maps.network_file import network_text
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo

# Two roads that cross, made up, in the form in which openstreetmap.org exports a part of the map.
ROAD = '<tag k="highway" v="residential"/><tag k="sidewalk" v="both"/><tag k="maxspeed" v="30"/>'
ZEBRA = '<tag k="highway" v="crossing"/><tag k="crossing" v="zebra"/>'
MAP = f"""<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6" generator="examples/real_street.py">
<node id="1" lat="60.17000" lon="24.93850"/>
<node id="2" lat="60.17000" lon="24.93973">{ZEBRA}</node>
<node id="3" lat="60.17000" lon="24.94000"/>
<node id="4" lat="60.17000" lon="24.94150"/>
<node id="5" lat="60.17080" lon="24.94000"/>
<node id="6" lat="60.16985" lon="24.94000">{ZEBRA}</node>
<node id="7" lat="60.16920" lon="24.94000"/>
<way id="1"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/>{ROAD}</way>
<way id="2"><nd ref="5"/><nd ref="3"/><nd ref="6"/><nd ref="7"/>{ROAD}</way>
</osm>
"""

with TemporaryDirectory() as folder:
    file = Path(folder) / "corner.osm"
    file.write_text(MAP, encoding="utf-8")
    corner = import_street(read_source(file), "corner")
    report = corner.report
    print(f"{report.name}: {report.verdict}: {'; '.join(report.reasons)}")
    for repair in report.repairs:
        print(f"repaired: {repair.what}, {repair.metres} m, at {repair.at}")
    assert corner.network is not None, report.reasons
    (Path(folder) / "corner.json").write_text(network_text(corner.network), encoding="utf-8")
    street = Street.create([str(Path(folder) / "corner.json")])  # what `jaxwalk import --out corner.json` writes

for name in ("route-follower", "clearance"):
    policies = {"driver": DRIVERS[name](), "pedestrian": AlwaysGo()}
    rows = evaluate(street, policies, Drawn(street, seed=0, count=64), batch=64)
    print(f"{name}: {rows[OUTCOMES].goal.mean():.0%} arrive, {rows[OUTCOMES].collision.mean():.0%} collide")
