"""Entries of catalogs: files beside a scenario that describe vehicles, pedestrians, trajectories and routes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

from jaxwalk.scenarios.xosc.elements import XoscRefusal, read_elements, word
from jaxwalk.scenarios.xosc.expressions import Scope, without_parameters

MOST_FILES = 200
"""Files that are looked at in a folder of catalogs."""


class CatalogEntries:
    """The catalogs that a document names."""

    def __init__(self, document: ET.Element, folder: Path) -> None:
        """Keep the folders of catalogs, which count from the folder of the document."""
        self.folders = [folder / word(one, "path") for one in document.findall("CatalogLocations/*/Directory")]
        self.known: dict[tuple[str, str], ET.Element | None] = {}

    def resolved(self, element: ET.Element) -> ET.Element:
        """Return an element, or the entry of a catalog to which it refers.

        Raise XoscRefusal if there is no such entry, or a parameter of it has no value.
        """
        if element.tag != "CatalogReference":
            return element
        key = word(element, "catalogName"), word(element, "entryName")
        if key not in self.known:
            self.known[key] = next(self._entries(*key), None)
        found = self.known[key]
        if found is None:
            raise XoscRefusal(
                f"CatalogReference {key[0]}/{key[1]}: isn't in the folders of CatalogLocations; "
                "put the catalog there, or write the element itself"
            )
        given = {
            word(one, "parameterRef"): word(one, "value")
            for one in element.findall("ParameterAssignments/ParameterAssignment")
        }
        return without_parameters(_assigned(found, given), Scope(given))

    def _entries(self, catalog: str, entry: str) -> Iterator[ET.Element]:
        for path in self._files():
            catalogs = read_elements(path, "OpenSCENARIO").findall("Catalog")
            named = (one for found in catalogs if found.get("name") == catalog for one in found)
            yield from (one for one in named if one.get("name") == entry)

    def _files(self) -> Iterator[Path]:
        for folder in dict.fromkeys(self.folders):
            if folder.is_file() and folder.suffix == ".xosc":
                yield folder
            elif folder.is_dir():
                yield from sorted(folder.glob("*.xosc"))[:MOST_FILES]


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
