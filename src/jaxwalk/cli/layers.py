"""Layers of a suite of crash tests, as an option names them."""

from __future__ import annotations

from collections.abc import Sequence

from jaxwalk.cli.errors import UsageError
from jaxwalk.scenarios.crash_suite import CrashSuite
from jaxwalk.scenarios.staging import layers_of

ALL = "all"
"""The word for all layers."""


def chosen_layers(names: Sequence[str], suite: CrashSuite) -> tuple[str, ...]:
    """Return the layers of a suite that an option names. Raise UsageError for one that there isn't, or none."""
    known = layers_of(suite)
    if not names:
        raise UsageError("--layers needs the name of a layer, such as standard")
    for name in names:
        if name not in (*known, ALL):
            raise UsageError(f"--layers {name}: the suite has no such layer; choose from {', '.join((*known, ALL))}")
    return known if ALL in names else tuple(dict.fromkeys(names))
