"""Map files to load: the bundled one as a table to change, a small one, and a way to write them."""

import json
import tomllib
from importlib import resources

import pytest


@pytest.fixture
def paper():
    """The bundled map's file as a table; every test has its own."""
    return tomllib.loads(resources.files("jaxwalk.maps").joinpath("paper.toml").read_text())


@pytest.fixture
def small():
    """A single road with one crosswalk."""
    return {
        "size": [60, 20],
        "car": {"places": [[5, 10], [40, 10]], "right_turn_radius": 5.0, "left_turn_radius": 8.0},
        "roads": {"only": [0, 6, 60, 14]},
        "sidewalks": {"south": [0, 4, 60, 6], "north": [0, 14, 60, 16]},
        "waypoints": {"s0": [1, 5], "s": [12, 5], "s1": [55, 5], "n0": [1, 15], "n": [12, 15], "n1": [55, 15]},
        "walkways": {"south": ["s0", "s", "s1"], "north": ["n0", "n", "n1"]},
        "crosswalks": {
            "only": {
                "area": [10, 6, 14, 14],
                "sides": [
                    {"landing": "s", "outer": "s1", "zone": [1, 25]},
                    {"landing": "n", "outer": "n1", "zone": [1, 25]},
                ],
            }
        },
    }


@pytest.fixture
def write(tmp_path):
    """Writes a table, or text as it is, to a map file and gives its path."""

    def write_map(content):
        path = tmp_path / "changed.toml"
        if isinstance(content, dict):
            content = "".join(f"{key} = {_toml(value)}\n" for key, value in content.items())
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write_map


def _toml(value):
    """A value as inline TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)
