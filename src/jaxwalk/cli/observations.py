"""``jaxwalk observations``."""

from __future__ import annotations

from jaxwalk.cli.options import Observations
from jaxwalk.sim.observation import OBSERVATIONS, PRIVILEGED_SETS, part, size


def run(options: Observations) -> int:
    """Print every observation set of the role: its features, and what 1 stands for in each."""
    for name, features in OBSERVATIONS[options.role].items():
        hidden = ", which no real car could have" if name in PRIVILEGED_SETS else ""
        print(f"{name}: {size(options.role, name)} features{hidden}")
        for feature in features:
            place = part(options.role, name, feature.name)
            print(f"  {place.start:4d} to {place.stop - 1:4d}  {feature.name:14}  {feature.units_in_words()}".rstrip())
    return 0
