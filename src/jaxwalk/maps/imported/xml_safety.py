"""XML from strangers: no document types, so no entities, and no more bytes than are asked for."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO
from xml.parsers import expat

from jaxwalk.maps.imported.refusals import ImportRefusal

CHUNK = 1 << 16
"""Bytes that are parsed at once."""


class _Begun(Exception):
    """The first element has begun: what may be dangerous can only stand before it."""


def refuse_declarations(path: Path, thing: str = "map") -> None:
    """Raise ImportRefusal if a file declares a document type, whose entities may grow without end, or isn't XML.

    ``thing`` is what the file should hold, for messages.
    """
    parser = expat.ParserCreate()

    def refuse(*_: object) -> None:
        raise ImportRefusal(f"{path}: declares a document type (<!DOCTYPE ...>), which no {thing} needs; remove it")

    def begun(*_: object) -> None:
        raise _Begun

    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = begun
    try:
        _parse(path, parser)
    except _Begun:
        return
    except expat.ExpatError as error:
        raise ImportRefusal(f"{path}: not XML that can be read ({error}); download it again") from None
    except (OSError, EOFError, zlib.error) as error:
        raise ImportRefusal(f"{path}: can't be read ({error}); download it again") from None
    raise ImportRefusal(f"{path}: has no element; name a file with a {thing}")


def _parse(path: Path, parser: expat.XMLParserType) -> None:
    with opened(path) as file:
        for chunk in iter(lambda: file.read(CHUNK), b""):
            parser.Parse(chunk)
        parser.Parse(b"", True)


@contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """Yield a file that is open to read, unpacked if it is packed with gzip."""
    with path.open("rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
    with gzip.open(path) if packed else path.open("rb") as file:
        yield file  # pyright: ignore[reportReturnType]
