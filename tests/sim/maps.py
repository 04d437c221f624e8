"""Maps made from the paper's: turned, and with more of everything."""

from __future__ import annotations

import copy
import json

import numpy as np

from jaxwalk.maps import read_map
from jaxwalk.maps.file import parse


def turned(table):
    """The map turned by 90 degrees to the left about its middle, (60, 60)."""
    table = copy.deepcopy(table)
    table["car"]["places"] = [_point(p) for p in table["car"]["places"]]
    table["waypoints"] = {name: _point(p) for name, p in table["waypoints"].items()}
    for areas in ("roads", "sidewalks"):
        table[areas] = {name: _area(a) for name, a in table[areas].items()}
    for crosswalk in table["crosswalks"].values():
        crosswalk["area"] = _area(crosswalk["area"])
    return table


def rearranged(table):
    """A map with a road, a sidewalk, waypoints and a place more, the branch 10 m longer."""
    table = copy.deepcopy(table)
    table["size"] = [130, 120]
    for areas, names in (("roads", ["branch"]), ("sidewalks", ["branch_south", "branch_north"])):
        for name in names:
            table[areas][name][2] = 130
    table["waypoints"] |= {"branch_s_far": [129, 81], "branch_n_far": [129, 91]}
    table["walkways"]["branch_south"].append("branch_s_far")
    table["walkways"]["branch_north"].append("branch_n_far")
    table["car"]["places"].append([120, 86])
    table["sidewalks"]["tee_east_outer"] = [60, 110, 62, 120]
    table["sidewalks"]["tee_east"][3] = 110
    return table


def write(path, table):
    path.write_text("".join(f"{key} = {_toml(value)}\n" for key, value in table.items()), encoding="utf-8")
    return path


def _point(point):
    return [120 - point[1], point[0]]


def _area(area):
    x0, y0, x1, y1 = area
    return [120 - y1, x0, 120 - y0, x1]


def _toml(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


def rectangles(kind, found=None):
    """The rectangles (rectangle, 4) of a map file's roads, sidewalks or crosswalks; of the paper's without a text."""
    found = found or read_map("paper")
    file = parse(found.text, found.name)
    parts = {"roads": file.roads, "sidewalks": file.sidewalks}
    parts["crosswalks"] = {name: crosswalk.area for name, crosswalk in file.crosswalks.items()}
    return np.array(list(parts[kind].values()))
