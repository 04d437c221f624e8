"""What is compiled otherwise for a GPU than for a CPU, and why. Results are the same.

On a GPU the host launches every kernel (2 to 3 us), and a loop or a branch that depends on data makes it wait for the
device: a step of the simulator takes as long as its launches do, whatever they compute. On a CPU nothing is launched,
and the work itself counts. So where the two want something else, code asks `few_launches`. The choice is made when a
program is traced: the programs of a CPU have no trace of it. ``docs/benchmark.md`` has what each choice saves.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import jax

_traced_for: list[str] = []
"""Platforms for which programs are traced besides JAX's own; the last one counts."""


def few_launches() -> bool:
    """Return whether launches count more than work, as on every device but a CPU."""
    return (_traced_for[-1] if _traced_for else jax.default_backend()) != "cpu"


@contextmanager
def traced_for(platform: str) -> Iterator[None]:
    """Trace programs for this platform (``cpu``, ``gpu``, ...) meanwhile, whatever JAX's own is.

    What was traced before is forgotten, on entering and on leaving: JAX doesn't know about this choice.
    """
    _traced_for.append(platform)
    jax.clear_caches()
    try:
        yield
    finally:
        _traced_for.pop()
        jax.clear_caches()
