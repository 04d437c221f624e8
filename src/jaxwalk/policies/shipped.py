"""Trained policies that ship with jaxwalk, by name. Each file has a model card beside it (``docs/policies.md``)."""

from __future__ import annotations

from pathlib import Path
from typing import Final

SHIPPED: Final[dict[str, dict[str, str]]] = {
    "driver": {
        "co-trained": "fast-co-trained",
        "single-agent": "fast-single-agent",
        "paper-co-trained": "paper-co-trained",
        "paper-single-agent": "paper-single-agent",
    },
    "pedestrian": {"learned": "fast-co-trained", "paper-learned": "paper-co-trained"},
}
"""For each role: the names that commands accept, and the file that each one stands for."""
FOLDER = Path(__file__).parent / "files"
"""The folder of the files."""


def shipped_policy(role: str, name: str) -> Path | None:
    """Return the file of a shipped policy, or None if the name isn't one."""
    file = SHIPPED[role].get(name)
    return None if file is None else FOLDER / f"{file}.safetensors"
