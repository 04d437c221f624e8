"""Validates documents by the schemas that come with scenariogeneration."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from importlib.metadata import files

import pytest

pytest.importorskip("scenariogeneration", reason="no scenariogeneration: pip install jaxwalk[scenarios]")
import xmlschema  # it comes with that


def valid(document, schema):
    """What is wrong with a document by a schema that comes with scenariogeneration."""
    (path,) = (file.locate() for file in files("scenariogeneration") or () if file.name == schema)
    return [error.reason for error in xmlschema.XMLSchema(str(path)).iter_errors(ET.fromstring(document))]
