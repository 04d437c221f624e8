"""Makes the street and the policies from the names in options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from jaxwalk.cli.checks import place
from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.options import Play, Rate, Report, Scenario, Search, Tracks
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.interfaces import Policy
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.scenarios import Archived
from jaxwalk.sim.environment import Street

Policies = dict[str, Policy]
"""Policies by the names given in the options."""


def cast(
    drivers: Sequence[str],
    people: Sequence[str],
    options: Play | Rate | Report | Scenario | Search | Tracks,
    kept: Archived | None = None,
    **loading: Any,
) -> tuple[Street, Policies, Policies]:
    """Return the street, the drivers and the populations that options name.

    Args:
        drivers: names as `jaxwalk evaluate` takes them.
        people: names of populations.
        options: where to play: without a map or a world, where the run folders among the names were trained.
        kept: scenarios of a file, which then decide where.
        loading: how `contestant` loads drivers (``trust``, ``seconds``).
    """
    with bad_values():
        street = world_of([*drivers, *people], place(options)) if kept is None else kept.street
        if options.jaywalk_multiplier is not None:
            street = with_jaywalk_multiplier(street, options.jaywalk_multiplier)
        cars = {name: contestant(street, "driver", name, **loading) for name in drivers}
        return street, cars, {name: contestant(street, "pedestrian", name) for name in people}
