"""The names of drivers and populations. This module imports no JAX, so that a wrong name is refused at once."""

from __future__ import annotations

from pathlib import Path

RULES = {
    "driver": (
        "random",
        "constant-speed",
        "rule-based",
        "rule-based-braking",
        "route-follower",
        "clearance",
        "cautious",
        "careful-human",
        "careful-human-aeb",
        "fuzzy-safety",
        "crosswalk-yield",
        "idm-yield",
        "belief-planner",
        "belief-planner-chance",
        "belief-planner-cvar",
        "oracle",
    ),
    "pedestrian": ("always-go", "gap-acceptance", "diffusion", "distracted", "pedsumo", "campus"),
}
"""The rules of each role: the names in `DRIVERS` and `POPULATIONS`."""
WITH_KNOB = (
    "clearance", "cautious", "careful-human", "careful-human-aeb", "fuzzy-safety", "crosswalk-yield", "idm-yield",
    "belief-planner", "belief-planner-chance", "belief-planner-cvar",
)  # fmt: skip
"""The drivers with a knob (`jaxwalk.policies.knobs`)."""
ON_THE_FRONTIER = ("route-follower", *WITH_KNOB, "co-trained", "single-agent", "town")
"""The drivers of `jaxwalk frontier`, unless others are named: the blind one, all with a knob, and trained ones."""
LOADERS = {".onnx": "onnx_file", ".pt": "torch_file", ".pt2": "torch_file", ".pth": "torch_file", ".zip": "sb3_file"}
"""Kinds of files of drivers not written in JAX, and the modules of `jaxwalk.policies.host` that load them."""


def is_host_driver(name: str) -> bool:
    """Return whether a name means a driver not written in JAX: ``module:Class``, ``file.py:Class`` or a known file."""
    return Path(name).suffix.lower() in LOADERS or is_class(name)


def is_class(name: str) -> bool:
    """Return whether a name means a class: ``module:Class`` or ``file.py:Class``."""
    home, _, attribute = name.rpartition(":")
    return bool(home) and attribute.isidentifier() and not Path(name).exists()
