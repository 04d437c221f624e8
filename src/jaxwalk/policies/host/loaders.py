"""The names of drivers that are not written in JAX, and the loader for each kind of name."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from jaxwalk.policies.host.driver import SECONDS, DriverError, HostDriver
from jaxwalk.policies.policy_names import LOADERS, is_class
from jaxwalk.sim.observation import OBSERVATIONS, size

GUESSES = ("route", "paper")
"""Observation sets to try for a file that names none: the first with the size of the network's input is taken."""


class Loader(Protocol):
    """Loads a file; returns the driver and the name of the observation set that it reads."""

    def __call__(self, path: Path, *, trust: bool) -> tuple[Any, str]: ...


def load_host_driver(name: str, *, trust: bool = False, seconds: float = SECONDS) -> HostDriver:
    """Return the driver with this name.

    Args:
        name: a name for which `is_host_driver` is true.
        trust: also load files that can run hidden code while they are loaded.
        seconds: time limit for one step [s].

    Raises:
        DriverError: there is no such driver, or it can't be used; the message says what to do.
    """
    if not seconds > 0:
        raise DriverError(f"{name}: its limit for a step must be above 0 s, not {seconds:g}")
    try:
        driver, observes = _load(name, trust=trust)
    except SystemExit as end:  # of a script, say; it must not end the evaluation as if all were done
        raise DriverError(
            f"{name}: exits while it is loaded (code {end.code}); remove the exit, or put it under "
            'if __name__ == "__main__"'
        ) from end
    sets = OBSERVATIONS["driver"]
    if observes not in sets:
        known = ", ".join(f"{x} ({size('driver', x)})" for x in sets)
        raise DriverError(f"{name}: observes {observes!r}, but there is no such observation set; there are: {known}")
    return HostDriver(name, driver, observes=observes, seconds=seconds)


def set_of_size(path: Path, features: int, observes: str | None = None) -> str:
    """Return the name of the observation set for a network with this many inputs.

    Raises DriverError if no set has this size, or if ``observes`` names a set of another size.
    """
    fitting = [name for name in GUESSES if size("driver", name) == features]
    if observes is None and fitting:
        return fitting[0]
    if observes in OBSERVATIONS["driver"] and size("driver", observes) == features:
        return observes
    sizes = ", ".join(f"{name} {size('driver', name)}" for name in OBSERVATIONS["driver"])
    named = f" and names the observation set {observes!r}" if observes else ""
    raise DriverError(
        f"{path}: takes {features} numbers{named}; the sets' sizes are: {sizes}; name one that fits (docs: drivers)"
    )


def _load(name: str, *, trust: bool) -> tuple[Any, str]:
    """Return the driver and the name of its observation set."""
    if not is_class(name):
        return _load_file(Path(name), trust=trust)
    from jaxwalk.policies.host.python_class import load_class

    return load_class(name)


def _load_file(path: Path, *, trust: bool) -> tuple[Any, str]:
    if not path.is_file():
        raise DriverError(f"{path}: no such file; check the name")
    load: Loader = import_module(f"jaxwalk.policies.host.{LOADERS[path.suffix.lower()]}").load
    return load(path, trust=trust)
