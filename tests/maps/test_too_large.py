"""A map that would fill memory, or be checked for ever, is refused at once."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from jaxwalk.maps import MapError, load_map


def _many(count):
    return {f"w{n}": [1 + n / 1000, 5] for n in range(count)}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"size": [1e9, 20]}, "size: 1e+09 m is beyond 2000 m; is it in metres?"),
        ({"waypoints": _many(501)}, "waypoints: 501 are too many; a map has at most 500"),
        ({"walkways": {"long": ["s0", "s"] * 60}}, "walkways.long: joins 120 waypoints; split it into pieces"),
        ({"roads": {"only": [0, 6, 1e300, 14]}}, "roads.only: 1e+300 m is beyond 2000 m"),
    ],
    ids=["size", "waypoints", "walkway", "road"],
)
def test_sizes_have_limits(small, write, change, message):
    with pytest.raises(MapError) as error:
        load_map(write(small | change))
    assert message in str(error.value)


def test_all_routes_between_many_places_are_too_many(small, write):
    small["car"]["places"] = [[5 + n, 10] for n in range(33)]
    with pytest.raises(MapError, match=r"car.routes: 1,056 are too many; list at most 1,000"):
        load_map(write(small))


def test_places_are_too_many_even_with_few_routes(small, write):
    small["car"] |= {"places": [[5 + n / 10, 10] for n in range(201)], "routes": [[0, 1]]}
    with pytest.raises(MapError, match=r"car.places: 201 are too many; a map has at most 200"):
        load_map(write(small))


def test_many_routes_on_a_large_map_do_not_fit(small, write):
    small["car"]["places"] = [[5 + n, 10] for n in range(32)]
    with pytest.raises(MapError, match=r"car.routes: 992 on a map of this size don't fit into memory; list fewer"):
        load_map(write(small | {"size": [1500, 20]}))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = " + "[" * 20_000, "not TOML that can be read"),
        ("a = " + "9" * 5_000, "not TOML that can be read"),
        ("# " + "x" * 1_000_001, "larger than 1,000,000 bytes"),
    ],
    ids=["brackets", "digits", "bytes"],
)
def test_text_that_no_parser_takes(write, text, message):
    with pytest.raises(MapError, match=message):
        load_map(write(text))


def test_a_long_value_is_shown_in_short(small, write):
    with pytest.raises(MapError) as error:
        load_map(write(small | {"size": ["x" * 100_000, 20]}))
    assert len(str(error.value)) < 400


@pytest.mark.skipif(os.name == "nt", reason="needs a device and a pipe")
@pytest.mark.parametrize("kind", ["device", "pipe", "folder"])
def test_what_is_no_file_is_not_read(tmp_path, kind):
    """A device may have no end, and a pipe no other."""
    path = tmp_path / "town.toml"
    {"device": lambda: path.symlink_to("/dev/zero"), "pipe": lambda: os.mkfifo(path), "folder": path.mkdir}[kind]()
    with pytest.raises(MapError, match="not a regular file: check the path"):
        load_map(path)


def test_no_more_is_read_than_a_map_has(tmp_path, monkeypatch):
    """Whatever the system says of a file's size."""
    path = tmp_path / "town.toml"
    path.write_text("# " + "x" * 2_000_000)
    monkeypatch.setattr(Path, "stat", lambda self, **_: os.stat_result((0o100644, *[0] * 9)))
    with pytest.raises(MapError, match="larger than 1,000,000 bytes"):
        load_map(path)
