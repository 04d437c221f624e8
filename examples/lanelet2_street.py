"""A street of a Lanelet2 map: lanelets in metres become a street, its report is checked, and a driver tries it."""

from pathlib import Path
from tempfile import TemporaryDirectory

from jaxwalk import DRIVERS, Drawn, Street
from jaxwalk.evaluation import evaluate
from jaxwalk.maps.imported.importing import import_street, read_source
from jaxwalk.maps.network_file import network_text
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo

# A road of 200 m with a lane in each direction, walkways along both kerbs and a zebra crossing, made up. Lines by their
# numbers: what they are, and the places of their two ends [m]. Lanelets: what they are, their left and right bounds.
LINES = {
    101: ("curbstone", (0.0, -3.5), (200.0, -3.5)),
    102: ("line_thin", (0.0, 0.0), (200.0, 0.0)),
    103: ("curbstone", (0.0, 3.5), (200.0, 3.5)),
    104: ("wall", (0.0, -6.0), (200.0, -6.0)),
    105: ("wall", (0.0, 6.0), (200.0, 6.0)),
    106: ("zebra_marking", (98.0, -3.5), (98.0, 3.5)),
    107: ("zebra_marking", (102.0, -3.5), (102.0, 3.5)),
}
LANELETS = {
    201: ("road", 102, 101), 202: ("road", 102, 103), 203: ("walkway", 101, 104), 204: ("walkway", 103, 105),
    205: ("crosswalk", 106, 107),
}  # fmt: skip


def tag(**tags: object) -> str:
    """Return tags as XML."""
    return "".join(f'<tag k="{key}" v="{value}"/>' for key, value in tags.items())


def lanelet_map() -> str:
    """Return the map as the XML that JOSM and Autoware's editors write."""
    nodes, ways = [], []
    for line, (kind, *ends) in LINES.items():
        for end, (x, y) in enumerate(ends):
            nodes.append(f'<node id="{10 * line + end}" lat="" lon="">{tag(local_x=x, local_y=y)}</node>')
        ways.append(f'<way id="{line}"><nd ref="{10 * line}"/><nd ref="{10 * line + 1}"/>{tag(type=kind)}</way>')
    lanelets = [
        f'<relation id="{number}"><member type="way" ref="{left}" role="left"/><member type="way" ref="{right}" '
        f'role="right"/>{tag(type="lanelet", subtype=subtype, speed_limit=30)}</relation>'
        for number, (subtype, left, right) in LANELETS.items()
    ]
    return "\n".join(["<osm>", *nodes, *ways, *lanelets, "</osm>"])


with TemporaryDirectory() as folder:
    file = Path(folder) / "road.osm"
    file.write_text(lanelet_map(), encoding="utf-8")
    road = import_street(read_source(file), "road", strict=True)  # strict: nothing is invented
    report = road.report
    print(f"{report.name}: {report.verdict}; {report.pavement.mapped:.0f} m of pavement are mapped")
    assert report.verdict == "usable" and [fact.kind for fact in report.facts] == ["zebra"], report
    assert road.network is not None
    (Path(folder) / "road.json").write_text(network_text(road.network), encoding="utf-8")
    street = Street.create([str(Path(folder) / "road.json")])  # what `jaxwalk import road.osm --out road.json` writes

policies = {"driver": DRIVERS["clearance"](), "pedestrian": AlwaysGo()}
rows = evaluate(street, policies, Drawn(street, seed=0, count=64), batch=64)
print(f"clearance: {rows[OUTCOMES].goal.mean():.0%} arrive, {rows[OUTCOMES].collision.mean():.0%} collide")
