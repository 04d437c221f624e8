"""The file of a network: JSON with a line for each part. ``docs/maps.md`` describes it."""

from __future__ import annotations

import json
from typing import Any

from pydantic import TypeAdapter, ValidationError

from jaxwalk.maps.file import MapError, explain
from jaxwalk.maps.network import Network

MOST_NETWORK_BYTES = 8_000_000
"""Largest size of a network's file [bytes]."""
MOST_FAULTS = 30
"""Faults that a message lists; of further ones it gives the number."""

_ADAPTER = TypeAdapter(Network)


def network_text(network: Network) -> str:
    """Return a network as the text of its file. `parse_network` gives exactly the same numbers again."""
    content: dict[str, Any] = _ADAPTER.dump_python(network, mode="json")
    if not network.attribution:  # so that files of generated streets stay as they are
        del content["attribution"]
    parts = ",\n".join(f'"{name}": {_lines(value)}' for name, value in content.items())
    return f"{{\n{parts}\n}}\n"


def parse_network(text: str, source: str) -> Network:
    """Return the network that a file's text describes; its geometry isn't checked.

    Raises MapError, which names ``source``, if it isn't JSON, or a key is unknown, missing or of the wrong type.
    """
    if len(text) > MOST_NETWORK_BYTES:
        raise MapError(source, [f"larger than {MOST_NETWORK_BYTES:,} bytes, which no street needs: cut it into parts"])
    try:
        return _ADAPTER.validate_json(text)
    except ValidationError as error:
        faults = [dict(fault) for fault in error.errors()]
    if faults[0]["type"] == "json_invalid":
        reason = str(faults[0]["msg"]).removeprefix("Invalid JSON: ")
        raise MapError(source, [f"not JSON that can be read ({reason}); correct the file"])
    raise MapError(source, shortened([explain(fault) for fault in faults]))


def shortened(faults: list[str]) -> list[str]:
    """Return at most `MOST_FAULTS` faults, and a line that counts the others."""
    others = len(faults) - MOST_FAULTS
    return faults[:MOST_FAULTS] + ([f"and {others:,} more faults"] if others > 0 else [])


def _lines(value: Any) -> str:
    """Return a value as JSON, an item of a list of parts on each line."""
    if not (isinstance(value, list) and value and isinstance(value[0], dict)):
        return json.dumps(value)
    return "[\n" + ",\n".join(f"  {json.dumps(item)}" for item in value) + "\n]"
