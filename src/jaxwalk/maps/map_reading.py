"""Reading and checking a map file. This module imports no JAX, so that a wrong map is refused at once."""

from __future__ import annotations

from dataclasses import replace
from importlib import resources
from pathlib import Path

from jaxwalk.maps.check import find_faults
from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.check_size import size_faults
from jaxwalk.maps.file import MapError, MapFile, parse
from jaxwalk.maps.map_text import MapText, text_hash
from jaxwalk.maps.network import Network
from jaxwalk.maps.network_file import MOST_NETWORK_BYTES, parse_network, shortened

MOST_BYTES = 1_000_000
"""Largest size of a map file [bytes]."""


def bundled_maps() -> list[str]:
    """Return the names of the maps that ship with jaxwalk."""
    folder = resources.files("jaxwalk.maps")
    return sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))


def checked(text: str, source: str, *, goal_spacing: float, start_clearance: float) -> MapFile | Network:
    """Return what the text of a map file, or of a network's file, says.

    ``source`` names the map in a MapError, which has a line for every fault.
    """
    if text.lstrip().startswith("{"):  # TOML never does
        network = parse_network(text, source)
        if faults := network_faults(network, goal_spacing=goal_spacing, start_clearance=start_clearance):
            raise MapError(source, shortened(faults))
        return network
    file = parse(text, source)
    if too_much := size_faults(file):
        raise MapError(source, too_much)
    if faults := find_faults(file, goal_spacing=goal_spacing, start_clearance=start_clearance):
        raise MapError(source, faults)
    return file


def read_map(name_or_path: str | Path) -> MapText:
    """Return the text of a bundled map or of a file. Raises MapError if it can't be read; its content isn't checked."""
    return MapText.of(map_name(name_or_path), map_content(name_or_path))


def reference(found: MapText) -> MapText:
    """Return a map as documents name it: without its text if it is one that ships with jaxwalk."""
    return replace(found, text=None) if _is_bundled(found) else found


def text_of(named: MapText) -> MapText:
    """Return a map of a document with its text, the inverse of `reference`.

    Raises MapError if the text isn't that of the hash, or if no such map ships with this jaxwalk.
    """
    if named.text is None and not _is_bundled(named):
        raise MapError(named.name, [f"no map of hash {named.hash} ships with this jaxwalk: use another version"])
    found = read_map(named.name) if named.text is None else named
    if text_hash(found.text or "") != found.hash:
        raise MapError(named.name, [f"its text was edited (the hash is not {named.hash}): copy it again"])
    return found


def _is_bundled(found: MapText) -> bool:
    return found.name in bundled_maps() and read_map(found.name).hash == found.hash


def map_name(name_or_path: str | Path) -> str:
    """Return a bundled map's name as it is, and a file's without its folder."""
    return Path(name_or_path).name


def map_content(name_or_path: str | Path) -> str:
    """Return the text of a map, without a byte-order mark. Raises MapError if it can't be read."""
    source = str(name_or_path)
    names = bundled_maps()
    if source in names:
        return resources.files("jaxwalk.maps").joinpath(f"{source}.toml").read_text(encoding="utf-8")
    if not source.endswith((".toml", ".json")):
        known = ", ".join(names)
        raise MapError(source, [f"no such map: use a bundled one ({known}), or the path of a .toml or .json file"])
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
