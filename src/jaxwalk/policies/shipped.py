"""Trained policies that come with jaxwalk, by name. Each file has its model card beside it (``docs/policies.md``)."""

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
"""Of each role, what people write, and the file that holds it."""
FOLDER = Path(__file__).parent / "files"
"""Where the files are."""


def shipped_policy(role: str, name: str) -> Path | None:
    """The file of a shipped policy; None for another name."""
    file = SHIPPED[role].get(name)
    return None if file is None else FOLDER / f"{file}.safetensors"
