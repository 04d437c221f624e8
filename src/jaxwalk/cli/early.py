"""Checks of names and files before JAX is imported, so that a wrong one is refused at once.

Options of all commands have the same names for the same things, so one check serves them all.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from jaxwalk.cli.checks import place
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import Share, Sweep, Train
from jaxwalk.maps import checked, each_map, map_content
from jaxwalk.maps.generated import names_generated
from jaxwalk.recipes import RECIPES, load_experiment
from jaxwalk.runs.contestant_names import check_name, run_folders
from jaxwalk.runs.folder import Run, check_new
from jaxwalk.sim.sim_config import SimConfig

PLAN = "plan.json"
"""File of a folder of `jaxwalk reproduce`, which `jaxwalk report` takes as well."""

FILES = ("files", "areas", "again", "answers", "config", "scenarios", "study")
"""Options that name files to read."""


def check_names(options: Any) -> None:
    """Raise an error, all of which are ValueErrors of jaxwalk, if the options name something that doesn't exist.

    Maps that are files are checked completely.
    """
    for path in (path for field in FILES for path in _many(options, field)):
        if not path.exists():
            raise UsageError(f"{path}: no such file; check the name")
    if isinstance(options, Train) and options.resume:
        Run.open(options.resume)
    elif isinstance(options, Train) and options.run_folder:
        check_new(options.run_folder)
    if isinstance(options, Sweep) and options.study:
        from jaxwalk.sweeps.study_file import load_sweep  # only here: every command begins with this module

        load_sweep(options.study)
    if hasattr(options, "people"):
        place(options)
    named = list(_named(options))
    for role, name in named:
        check_name(role, name)
    runs = [Run.open(name) for name in run_folders(name for _, name in named)]
    sim = runs[0].experiment.sim if runs else SimConfig()
    for name in each_map(_maps(options)):
        text = map_content(name)
        if not names_generated(name):  # generated streets are checked when they are made
            checked(text, name, goal_spacing=sim.goal_spacing, start_clearance=sim.start_clearance)


def _named(options: Any) -> Iterator[tuple[str, str]]:
    """Yield role and name of each driver and population."""
    for field in ("driver", "drivers", "compare", "runs"):
        yield from (("driver", name) for name in _many(options, field) if not (Path(name) / PLAN).is_file())
    yield from (("driver", name) for name in _many(options, "beside") if name != "none")
    yield from (("pedestrian", name) for name in _many(options, "pedestrians") if isinstance(name, str))
    yield from ((options.role, name) for name in _many(options, "policy"))
    if isinstance(options, Share):
        yield "driver", str(options.run_folder.resolve())  # the whole path can't be a shipped policy's name


def _maps(options: Any) -> tuple[str, ...]:
    """Return the maps that options, or the file of a training, name."""
    named = _many(options, "map")
    if isinstance(options, Train) and options.config:
        return named or load_experiment(options.config, RECIPES).maps
    return named


def _many(options: Any, field: str) -> tuple[Any, ...]:
    """Return the values of an option, of which there may be one, several or none."""
    value = getattr(options, field, None)
    return value if isinstance(value, tuple) else () if value in (None, "") else (value,)
