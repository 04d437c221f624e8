"""What the names of drivers, populations and run folders stand for. This module imports no JAX."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from jaxwalk.policies import SHIPPED, shipped_policy
from jaxwalk.policies.mixture_names import MixtureError, mixture_of
from jaxwalk.policies.policy_names import RULES, is_class, is_host_driver
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.runs.folder import Run, RunError


class ContestantError(ValueError):
    """The name of no driver or population. The message says what to do, in one line."""


def run_folders(names: Iterable[str]) -> list[str]:
    """Return the names that are run folders. Names of rules and of shipped policies come first."""
    known = {name for role, rules in RULES.items() for name in (*rules, *SHIPPED[role])}
    bare = [unshielded("driver", name)[0] for name in names]
    each = [kind for name in bare for kind in (_kinds_named(name) or [name])]
    return [name for name in each if name not in known and Path(name).is_dir()]


def _kinds_named(name: str) -> list[str]:
    """Return the kinds of a mixture; none if it isn't a proper one."""
    try:
        return list(mixture_of("pedestrian", name))
    except MixtureError:
        return []


def check_name(role: str, name: str) -> None:
    """Raise ContestantError, MixtureError or RunError if nothing has that name. What a file holds isn't checked."""
    name, _ = unshielded(role, name)
    mixed = mixture_of(role, name)
    for kind in mixed:
        check_name(role, kind)
    if mixed or name in RULES[role]:
        return
    if role != "driver" or not is_host_driver(name):
        policy_file(role, name)
        return
    file = name.rpartition(":")[0] if is_class(name) else name
    is_module = is_class(name) and not file.endswith(".py")
    if not is_module and not Path(file).is_file():
        raise ContestantError(f"{name}: no such file; check the name")


def policy_file(role: str, name: str) -> Path:
    """Return the file of a shipped policy, a run folder or itself. Raise ContestantError or RunError if it is none."""
    shipped = shipped_policy(role, name)
    if shipped is not None:
        return shipped
    path = Path(name)
    if path.is_dir():
        file = Run.open(path).policy
        if not file.is_file():
            hint = f"go on with the training: jaxwalk train --resume {path}"
            raise RunError(f"{path}: has no {file.name}: it stopped before its first checkpoint; {hint}")
        return file
    if path.suffix == ".py" and path.is_file():
        raise ContestantError(f"{name}: name the class in it too, as in {name}:MyDriver")
    if path.is_file():
        return path
    known = ", ".join((*RULES[role], *SHIPPED[role]))
    raise ContestantError(f"{name}: no {role} of that name ({known}), and no run folder or policy file; check the name")
