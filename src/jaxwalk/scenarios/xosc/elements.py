"""Elements of an OpenSCENARIO document: read safely, and asked for numbers and words."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

from jaxwalk.maps.imported.xml_safety import refuse_declarations

MOST_DOCUMENT_BYTES, DEEPEST, MOST_ELEMENTS = 20_000_000, 60, 500_000
"""Largest size of a file [bytes], depth of its elements, and number of them."""
LARGEST_NUMBER = 1e9
"""No number of a file is larger."""


class XoscRefusal(ValueError):
    """What a file says can't be read or played. The message is one line that names the element; not the file."""


def read_elements(path: Path, name: str) -> ET.Element:
    """Return the root of a document, which must have this name. Raise XoscRefusal if it can't be read."""
    try:
        size = path.stat().st_size
        if size > MOST_DOCUMENT_BYTES:
            raise XoscRefusal(f"larger than {MOST_DOCUMENT_BYTES:,} bytes, which no scenario needs; check the path")
        refuse_declarations(path, "scenario")
        root = _parsed(path)
    except OSError as error:
        raise XoscRefusal(f"can't be read ({error.strerror}); check the path") from None
    except XoscRefusal:
        raise
    except (ET.ParseError, ValueError, LookupError) as error:  # ImportRefusal is a ValueError
        reason = str(error).removeprefix(f"{path}: ")
        raise XoscRefusal(reason if "<!DOCTYPE" in reason else f"not XML that can be read ({reason})") from None
    if root.tag != name:
        raise XoscRefusal(f"its first element is {root.tag[:60]}, not {name}; name a scenario file")
    return root


def _parsed(path: Path) -> ET.Element:
    depth = count = 0
    root: ET.Element | None = None
    for event, element in ET.iterparse(path, ("start", "end")):
        if event == "end":
            depth -= 1
            continue
        root = element if root is None else root
        depth, count = depth + 1, count + 1
        element.tag = element.tag.rpartition("}")[2]
        if depth > DEEPEST or count > MOST_ELEMENTS:
            raise XoscRefusal(f"more than {DEEPEST} elements in each other, or {MOST_ELEMENTS:,} in all; simplify it")
    assert root is not None
    return root


def called(element: ET.Element) -> str:
    """Return an element's tag, with its name if it has one, for messages."""
    name = next((element.get(key) for key in ("name", "entityRef") if element.get(key)), None)
    return element.tag if name is None else f"{element.tag} {name[:60]!r}"


def number(element: ET.Element, name: str, default: float | None = None) -> float:
    """Return a number of an element, ``default`` if it isn't given. Raise XoscRefusal if it is none."""
    text = element.get(name)
    if text is None and default is not None:
        return default
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not abs(value) <= LARGEST_NUMBER:
        said = "is missing" if text is None else f"{text[:60]!r} is no number that can be used"
        raise XoscRefusal(f"{called(element)}: {name} {said}; correct it")
    return value


def word(element: ET.Element, name: str, default: str | None = None) -> str:
    """Return a word of an element. Raise XoscRefusal if it is missing and has no default."""
    text = element.get(name, default)
    if text is None:
        raise XoscRefusal(f"{called(element)}: {name} is missing; add it")
    return text


def part(element: ET.Element, path: str) -> ET.Element:
    """Return what is inside an element. Raise XoscRefusal if it isn't there."""
    found = element.find(path)
    if found is None:
        raise XoscRefusal(f"{called(element)}: has no {path}; add it")
    return found


def only(element: ET.Element) -> ET.Element:
    """Return the one element inside another, such as the kind of an action. Raise XoscRefusal if there is none."""
    for found in element:
        return found
    raise XoscRefusal(f"{called(element)}: is empty; say what it does, or remove it")


def entity_refs(element: ET.Element, path: str) -> Iterator[str]:
    """Yield the names of the entities to which some elements inside refer."""
    return (word(one, "entityRef") for one in element.findall(f"{path}/EntityRef"))
