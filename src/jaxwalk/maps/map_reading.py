"""Reading and checking a map file. This module imports no JAX, so that a wrong map is refused at once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path

from jaxwalk.maps.check import find_faults
from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.check_size import size_faults
from jaxwalk.maps.file import MapError, MapFile, parse
from jaxwalk.maps.generated.check_town import DISTANCES
from jaxwalk.maps.generated.named_streets import (
    FORMS,
    MOST_STREETS,
    each_name,
    generated_text,
    names_generated,
)
from jaxwalk.maps.map_network import network_of
from jaxwalk.maps.map_text import MapText, text_hash
from jaxwalk.maps.network import Network
from jaxwalk.maps.network_file import MOST_NETWORK_BYTES, network_text, parse_network, shortened
from jaxwalk.maps.test_track import TEST_TRACK, track_network

IMPORT_REPORT = "report.json"
"""How the name of a report ends that `jaxwalk import` writes beside streets."""
MOST_BYTES = 1_000_000
"""Largest size of a map file [bytes]."""


def bundled_maps() -> list[str]:
    """Return the names of the maps that ship with jaxwalk."""
    folder = resources.files("jaxwalk.maps")
    files = (entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))
    return sorted([*files, TEST_TRACK])


def checked(text: str, source: str, *, goal_spacing: float, start_clearance: float) -> MapFile | Network:
    """Return what the text of a map file, or of a network's file, says.

    ``source`` names the map in a MapError, which has a line for every fault.
    """
    if _is_network(text):
        network = parse_network(text, source)
        distances = {"goal_spacing": goal_spacing, "start_clearance": start_clearance}
        if distances == DISTANCES and _is_made(text, source):
            return network  # checked when it was made; checking takes as long as making the tables
        if faults := network_faults(network, **distances):
            raise MapError(source, shortened(faults))
        return network
    file = parse(text, source)
    if too_much := size_faults(file):
        raise MapError(source, too_much)
    if faults := find_faults(file, goal_spacing=goal_spacing, start_clearance=start_clearance):
        raise MapError(source, faults)
    return file


def load_network(name_or_path: str | Path, *, goal_spacing: float = 20.0, start_clearance: float = 10.0) -> Network:
    """Return a map as a network: lanes, areas and ways of people. Names, distances and errors are `load_map`'s."""
    text, source = map_content(name_or_path), str(name_or_path)
    found = checked(text, source, goal_spacing=goal_spacing, start_clearance=start_clearance)
    return found if isinstance(found, Network) else network_of(found)


def as_network(found: MapText) -> Network:
    """Return the network of a map's text without faults."""
    text = found.text or ""
    return parse_network(text, found.name) if _is_network(text) else network_of(parse(text, found.name))


def read_map(name_or_path: str | Path) -> MapText:
    """Return the text of a bundled map, a file or a generated street.

    Raises MapError if it can't be read; the content of a file isn't checked.
    """
    return MapText.of(map_name(name_or_path), map_content(name_or_path))


def each_map(names: Iterable[str | Path]) -> tuple[str, ...]:
    """Return names in which each is that of one map: ``test:2`` becomes ``test-2000000000``, ``test-2000000001``.

    A folder becomes the paths of the networks in it. Raises MapError for an impossible number of streets.
    """
    return tuple(one for name in names for one in (_in_folder(name) or each_name(str(name))))


def _in_folder(name: str | Path) -> tuple[str, ...]:
    """Return the paths of the networks in a folder, () for the name of anything else."""
    if str(name) in bundled_maps() or names_generated(str(name)) or not Path(name).is_dir():
        return ()
    found = sorted(path for path in Path(name).glob("*.json") if not path.name.endswith(IMPORT_REPORT))
    if not 1 <= len(found) <= MOST_STREETS:
        raise MapError(
            str(name), [f"the folder has {len(found):,} streets (.json); it must have 1 to {MOST_STREETS:,}"]
        )
    return tuple(str(path) for path in found)


def reference(found: MapText) -> MapText:
    """Return a map as documents name it: without its text if jaxwalk ships it, or makes it from its number."""
    return replace(found, text=None) if _is_known(found) else found


def text_of(named: MapText) -> MapText:
    """Return a map of a document with its text, the inverse of `reference`.

    Raises MapError if the text isn't that of the hash, or if this jaxwalk neither ships nor makes such a map.
    """
    if named.text is None and not _is_known(named):
        raise MapError(named.name, [f"this jaxwalk has no map of hash {named.hash}: use another version"])
    found = read_map(named.name) if named.text is None else named
    if text_hash(found.text or "") != found.hash:
        raise MapError(named.name, [f"its text was edited (the hash is not {named.hash}): copy it again"])
    return found


def _is_network(text: str) -> bool:
    return text.lstrip().startswith("{")  # TOML never does


def _is_made(text: str, name: str) -> bool:
    """Return whether a text is that of the generated street of this name."""
    try:
        return names_generated(name) and generated_text(name) == text
    except MapError:  # a number that another version gave a street
        return False


def _is_known(found: MapText) -> bool:
    """Return whether a map ships with jaxwalk, or is the street that it makes from the number in its name."""
    try:
        known = found.name in bundled_maps() or names_generated(found.name)
        return known and read_map(found.name).hash == found.hash
    except MapError:  # a number that another version gave a street
        return False


@cache
def _test_track_text() -> str:
    return network_text(track_network())


def map_name(name_or_path: str | Path) -> str:
    """Return the name of a bundled map or a generated street as it is, and a file's without its folder."""
    return Path(name_or_path).name


def map_content(name_or_path: str | Path) -> str:
    """Return the text of a map, without a byte-order mark. Raises MapError if it can't be read."""
    source = str(name_or_path)
    names = bundled_maps()
    if source == TEST_TRACK:
        return _test_track_text()
    if source in names:
        return resources.files("jaxwalk.maps").joinpath(f"{source}.toml").read_text(encoding="utf-8")
    if names_generated(source):
        return generated_text(source)
    if not source.endswith((".toml", ".json")):
        known = f"a bundled one ({', '.join(names)}), generated ones ({FORMS})"
        raise MapError(source, [f"no such map: use {known}, or the path of a .toml or .json file"])
    most = MOST_BYTES if source.endswith(".toml") else MOST_NETWORK_BYTES
    path = Path(source)
    if path.exists() and not path.is_file():  # a folder, an endless device, a pipe without a writer
        raise MapError(source, ["not a regular file: check the path"])
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
        if len(content) > most:
            raise MapError(source, [f"larger than {most:,} bytes, which no map needs: check the path"])
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise MapError(source, ["not UTF-8 text: save the file as UTF-8"]) from None
    except OSError as error:
        raise MapError(source, [f"cannot be read ({error.strerror}): check the path"]) from None
