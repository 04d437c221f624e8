"""Trained policies that ship with jaxwalk, by name. Each file has a model card beside it (``docs/policies.md``)."""

from __future__ import annotations

from pathlib import Path
from typing import Final

SHIPPED: Final[dict[str, dict[str, str]]] = {
    "driver": {
        "co-trained": "fast-0.2-co-trained",
        "single-agent": "fast-0.2-single-agent",
        "co-trained-0.2": "fast-0.2-co-trained",
        "single-agent-0.2": "fast-0.2-single-agent",
        "town": "town-0.2-co-trained",
        "town-0.2": "town-0.2-co-trained",
        "blind-corner": "blind-corner-0.2-single-agent",
        "blind-corner-0.2": "blind-corner-0.2-single-agent",
        "co-trained-0.1": "fast-0.1-co-trained",
        "single-agent-0.1": "fast-0.1-single-agent",
        "paper-co-trained": "paper-co-trained",
        "paper-single-agent": "paper-single-agent",
    },
    "pedestrian": {
        "learned": "fast-0.2-co-trained",
        "learned-0.2": "fast-0.2-co-trained",
        "town-learned": "town-0.2-co-trained",
        "town-learned-0.2": "town-0.2-co-trained",
        "learned-0.1": "fast-0.1-co-trained",
        "paper-learned": "paper-co-trained",
    },
}
"""For each role: the names that commands accept, and the file that each one stands for. A name with a version keeps its
file; one without stands for the newest."""
FOLDER = Path(__file__).parent / "files"
"""The folder of the files."""


def shipped_policy(role: str, name: str) -> Path | None:
    """Return the file of a shipped policy, or None if the name isn't one."""
    file = SHIPPED[role].get(name)
    return None if file is None else FOLDER / f"{file}.safetensors"
