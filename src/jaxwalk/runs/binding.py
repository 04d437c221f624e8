"""Binds checkpoints and policy files to the configuration and the maps that they were made with."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from jaxwalk.learning import checkpoint
from jaxwalk.maps import MapText
from jaxwalk.runs.folder import CONFIG, Run, RunError, as_json, from_json

PLAN = {"train.updates", "minutes"}
"""What a training changes in its configuration by itself, when it plans its updates or changes the plan on the way."""


class EditedConfigError(RunError):
    """A configuration was changed since a checkpoint was made with it."""


def bound_to(run: Run, maps: Sequence[MapText], archives: Sequence[str] = ()) -> dict[str, Any]:
    """Return what a checkpoint of the run keeps: the configuration and the hashes of maps and kept scenarios."""
    hashes = [found.hash for found in maps]
    return {"configuration": as_json(run.experiment), "maps": hashes, "archives": list(archives)}


def policy_bound_to(run: Run, maps: Sequence[MapText], archives: Sequence[str] = ()) -> dict[str, Any]:
    """Return what a policy file of the run states: its maps, hashes of kept scenarios, and the configuration's hash."""
    names, hashes = [found.name for found in maps], [found.hash for found in maps]
    return {"maps": names, "map_hashes": hashes, "archive_hashes": list(archives), "config_hash": run.hash}


def check_intact(run: Run) -> None:
    """Raise EditedConfigError if the configuration isn't as jaxwalk wrote it."""
    if run.intact is False:
        raise EditedConfigError(
            f"{run.path}: {CONFIG} was edited since its policy was trained; undo the change, or name the policy file"
        )


def check_bound(run: Run, maps: Sequence[MapText], tell: Callable[[str], None], archives: Sequence[str] = ()) -> None:
    """Raise EditedConfigError if the newest checkpoint was made with another configuration, maps or kept scenarios.

    ``tell`` is called with a warning if the checkpoint doesn't say with which, as those of older versions.
    """
    updates = checkpoint.latest(run.checkpoints)
    if updates is None:
        return
    made = checkpoint.kept_with(run.checkpoints, updates)
    if "configuration" not in made and run.intact is not False:
        tell(f"{run.path}: checkpoint {updates} doesn't say with which configuration it was made; {CONFIG} is believed")
        return
    changed = _changed(run, made.get("configuration", {}))
    if made.get("maps", []) != [found.hash for found in maps]:
        changed.append("the content of the maps")
    if made.get("archives", []) != list(archives):
        raise EditedConfigError(
            f"{run.path}: the kept scenarios aren't those of checkpoint {updates}; restore archive-N.safetensors, or "
            "begin another training with --run"
        )
    if changed or run.intact is False:
        what = ", ".join(changed) or "its hash differs"
        raise EditedConfigError(
            f"{run.path}: {CONFIG} was edited since checkpoint {updates} was made ({what}); undo the change to resume, "
            "or begin another training with --run"
        )


def _changed(run: Run, before: Mapping[str, Any]) -> list[str]:
    """Return the names of the fields that differ, but for `PLAN` if the file is as the training wrote it."""
    try:
        known = as_json(from_json(before))  # fields that are new in this version have their defaults
    except ValidationError:
        known = before
    old, new = dict(_fields(known)), dict(_fields(as_json(run.experiment)))
    expected = PLAN if run.intact else set()
    return [name for name in {**new, **old} if name not in expected and new.get(name) != old.get(name)]


def _fields(document: Mapping[str, Any], inside: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the dotted name and the value of every field."""
    for name, value in document.items():
        if isinstance(value, dict):
            yield from _fields(value, f"{inside}{name}.")
        else:
            yield f"{inside}{name}", value
