"""The machine's peak: the rate of square matrix products in 32-bit numbers, as XLA compiles them."""

from __future__ import annotations

import time
from typing import Any

import jax
import jax.numpy as jnp

from jaxwalk.bench.machine import accelerated

CALL_SECONDS = 0.05
"""Time of one measured call: as many products as fit into it are started without waiting in between [s]."""


def peak_products(sides: tuple[int, ...], seconds: float) -> list[dict[str, Any]]:
    """Return the best rate of each size; on an accelerator also with the full precision of 32-bit numbers."""
    precisions = ("default", "highest") if accelerated() else ("default",)
    return [_rate(side, precision, min(seconds, 1.0)) for precision in precisions for side in sides]


def _rate(side: int, precision: str, seconds: float) -> dict[str, Any]:
    a, b = (jax.random.normal(jax.random.key(k), (side, side)) for k in range(2))
    multiply = jax.jit(lambda a, b: jnp.matmul(a, b, precision=precision))
    jax.block_until_ready(multiply(a, b))
    times = [_seconds(multiply, a, b, 1)]
    calls = max(1, round(CALL_SECONDS / times[0]))
    while sum(times) * calls < seconds or len(times) < 4:
        times.append(_seconds(multiply, a, b, calls))
    return {"side": side, "precision": precision, "flops": 2 * side**3 / min(times)}


def _seconds(multiply: Any, a: jax.Array, b: jax.Array, calls: int) -> float:
    """Return the mean time of a call [s]."""
    begun = time.perf_counter()
    jax.block_until_ready([multiply(a, b) for _ in range(calls)])
    return (time.perf_counter() - begun) / calls
