"""Entries of catalogs: files beside a scenario that describe vehicles, pedestrians, trajectories and routes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from jaxwalk.scenarios.xosc.elements import XoscRefusal, read_elements, word
from jaxwalk.scenarios.xosc.expressions import Scope, without_parameters

MOST_FILES = 200
"""Files that are looked at in a folder of catalogs."""


class CatalogEntry(NamedTuple):
    """An entry of a catalog, as it stands in its file."""

    element: ET.Element
    file: str
    """The name of the file."""


class CatalogEntries:
    """The catalogs that a document names."""

    def __init__(self, document: ET.Element, folder: Path) -> None:
        """Keep the folders of catalogs, which count from the folder of the document."""
        self.folders = [folder / word(one, "path") for one in document.findall("CatalogLocations/*/Directory")]
        self.known: dict[tuple[str, str], CatalogEntry] = {}
        self.read: dict[Path, list[ET.Element]] = {}

    def resolved(self, element: ET.Element) -> ET.Element:
        """Return an element, or the entry of a catalog to which it refers.

        Raise XoscRefusal if there is no such entry, or a parameter of it has no value.
        """
        if element.tag != "CatalogReference":
            return element
        given = {
            word(one, "parameterRef"): word(one, "value")
            for one in element.findall("ParameterAssignments/ParameterAssignment")
        }
        with self.naming(element):
            return without_parameters(_assigned(self._entry(element).element, given), Scope(given))

    @contextmanager
    def naming(self, element: ET.Element) -> Iterator[None]:
        """Name file and entry of a reference in each XoscRefusal that is raised inside."""
        if element.tag != "CatalogReference":
            yield
            return
        entry = self._entry(element)
        try:
            yield
        except XoscRefusal as error:
            label = f"{_called(element)} in {entry.file}: "
            raise XoscRefusal(label + str(error).removeprefix(label)) from None

    def _entry(self, reference: ET.Element) -> CatalogEntry:
        key = word(reference, "catalogName"), word(reference, "entryName")
        if key not in self.known:
            found = next(self._entries(*key), None)
            if found is None:
                raise XoscRefusal(
                    f"{_called(reference)}: isn't in the folders of CatalogLocations; "
                    "put the catalog there, or write the element itself"
                )
            self.known[key] = found
        return self.known[key]

    def _entries(self, catalog: str, entry: str) -> Iterator[CatalogEntry]:
        for path in self._files():
            named = (one for found in self._catalogs(path) if found.get("name") == catalog for one in found)
            yield from (CatalogEntry(one, path.name) for one in named if one.get("name") == entry)

    def _catalogs(self, path: Path) -> list[ET.Element]:
        """Return the catalogs of a file. Raise XoscRefusal, which names it, if it can't be read."""
        if path not in self.read:
            try:
                self.read[path] = read_elements(path, "OpenSCENARIO").findall("Catalog")
            except XoscRefusal as error:
                raise XoscRefusal(f"catalog {path.name}: {error}") from None
        return self.read[path]

    def _files(self) -> Iterator[Path]:
        for folder in dict.fromkeys(self.folders):
            if folder.is_file() and folder.suffix == ".xosc":
                yield folder
            elif folder.is_dir():
                yield from sorted(folder.glob("*.xosc"))[:MOST_FILES]


def _called(reference: ET.Element) -> str:
    return f"CatalogReference {word(reference, 'catalogName')}/{word(reference, 'entryName')}"


def _assigned(entry: ET.Element, given: dict[str, str]) -> ET.Element:
    """Return an entry with the values that a reference gives its parameters."""
    copy = ET.Element(entry.tag, entry.attrib)
    for one in entry:
        if one.tag != "ParameterDeclarations":
            copy.append(one)
            continue
        declared = ET.SubElement(copy, one.tag)
        for parameter in one:
            value = given.get(parameter.get("name", ""), parameter.get("value", ""))
            ET.SubElement(declared, parameter.tag, parameter.attrib | {"value": value})
    return copy
