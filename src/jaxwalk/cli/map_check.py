"""``jaxwalk map check``."""

from __future__ import annotations

from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import MapCheck
from jaxwalk.maps import each_map, load_network
from jaxwalk.maps.network import Network
from jaxwalk.wording import counted


def run(options: MapCheck) -> int:
    """Print what each map is like; the first one with faults ends the command with all of them."""
    if not options.map:
        raise UsageError("name a map: a file, a bundled map or a generated street")
    for name in each_map(options.map):
        print(f"{name}: no faults; {describe(load_network(name))}")
    return 0


def describe(network: Network) -> str:
    """Return the size of a street, and how many parts of each kind it has, in words."""
    width, height = network.size
    zones = sum(crossing.zone is not None for crossing in network.crossings)
    parts = (
        counted(len(network.lanes), "lane"), counted(len(network.routes), "route"),
        f"{counted(len(network.crossings), 'crossing')}, {zones} of them with a jaywalk zone",
        counted(network.walk.waypoints, "waypoint"),
    )  # fmt: skip
    return f"{width:g} x {height:g} m, {', '.join(parts)}"
