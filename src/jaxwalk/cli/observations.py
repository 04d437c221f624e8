"""``jaxwalk observations``."""

from __future__ import annotations

from jaxwalk.cli.options import Observations
from jaxwalk.sim.observation import HIDDEN, LAYOUTS, part, size


def run(options: Observations) -> int:
    """Print every set of the role."""
    for name, layout in LAYOUTS[options.role].items():
        hidden = ", which no real car could have" if name in HIDDEN else ""
        print(f"{name}: {size(options.role, name)} features{hidden}")
        for which in layout:
            place = part(options.role, name, which)
            print(f"  {place.start:4d} to {place.stop - 1:4d}  {which}")
    return 0
