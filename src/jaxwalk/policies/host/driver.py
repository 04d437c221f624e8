"""A driver that is not written in JAX, behind one protocol: NumPy in, NumPy out, a whole batch at once.

    class MyDriver:
        observes = "route"              # the observation set it reads; "paper" if there is none

        def reset(self, episodes):      # optional: a new batch of this many episodes begins
            ...

        def act(self, observation):     # float32 (episodes, features) -> (episodes, 2), all in [-1, 1]
            ...

An action is acceleration and steering, as shares of their limits. It may depend only on what the driver has observed
since the last ``reset``.
"""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from queue import Empty, SimpleQueue
from textwrap import shorten
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import Box
from jaxwalk.sim.observation import Observation

SECONDS = 10.0
"""Default time limit of a driver for one step of its batch [s]."""
NUMBERS = "fiu"
"""Kinds of NumPy types that are real numbers."""
ACTION = Box(2)
"""The space of a driver's action: acceleration and steering."""
MESSAGE = 300
"""Longest quotation of an error message from a driver [characters]."""


class DriverError(ValueError):
    """A driver can't be used. The message names the driver, says what is wrong and what to do, in one line."""


class HostDriver:
    """A driver with the protocol above, as a `Policy` that can't be compiled: its ``act`` takes concrete arrays only.

    The driver keeps its own memory, so it plays one batch at a time: a caller holds its `lock` meanwhile. After
    the first failure, every call raises the same error.
    """

    def __init__(self, name: str, driver: Any, *, observes: str, seconds: float = SECONDS) -> None:
        """Wrap ``driver``, which follows the protocol; messages call it ``name``; one step may take ``seconds``."""
        self.name, self.view = name, Observation("driver", observes)
        self.lock = threading.Lock()
        self.seconds_spent, self.steps_made = 0.0, 0
        self.failure: str | None = None
        self._driver, self._seconds = driver, seconds
        self._thread = _Thread()

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Tell the driver that a new batch begins. Raises DriverError if the driver has failed before or fails now."""
        if self.failure:
            raise DriverError(self.failure)
        if hasattr(self._driver, "reset"):
            self._ask("reset", *batch)

    def act(
        self, key: Key[Array, "episode"] | None, memory: None, observation: Float[Array, "feature episode"]
    ) -> tuple[Float[Array, "2 episode"], None]:
        """Return the driver's actions. Their shape and type are checked, their values are as the driver gave them.

        Raises DriverError if the driver raises, takes too long or returns anything but two numbers for each episode.
        """
        rows = np.array(np.asarray(observation).T, np.float32, order="C")  # a copy, because the driver may write to it
        begun = time.perf_counter()
        answer = self._ask("act", rows)
        self.seconds_spent += time.perf_counter() - begun
        self.steps_made += 1
        return jnp.asarray(self._checked(answer, len(rows)).T), memory

    def fail(self, what: str) -> DriverError:
        """Record a failure and return the error to raise. ``what`` says what the driver did wrong."""
        self.failure = what if what.startswith(f"{self.name}: ") else f"{self.name}: {what}"
        return DriverError(self.failure)

    def _ask(self, method: str, *arguments: Any) -> Any:
        """Call a method of the driver and return its result. Raises DriverError if it raises or takes too long."""
        try:
            return self._thread.call(self._call, (method, *arguments), self._seconds)
        except TimeoutError as error:
            raise self.fail(
                f"{method} took longer than {self._seconds:g} s; make it quicker, or allow more with --driver-seconds"
            ) from error
        except _RaisedError as raised:
            cause = raised.cause
            raise self.fail(f"{method} raised {_described(cause)}") from cause

    def _call(self, method: str, *arguments: Any) -> Any:
        """Call a method of the driver. Looking it up is the driver's own code too, where it is a property."""
        return getattr(self._driver, method)(*arguments)

    def _checked(self, answer: Any, episodes: int) -> np.ndarray:
        """Return the answer as float32 ``(episodes, 2)``. Raises DriverError if it is something else."""
        wanted = f"an array of shape ({episodes}, 2): acceleration and steering in [-1, 1] for each episode"
        try:
            actions = np.asarray(answer)
        except (Exception, SystemExit) as error:
            raise self.fail(f"act returned {type(answer).__name__}, which is no array; return {wanted}") from error
        if actions.dtype.kind not in NUMBERS:
            raise self.fail(f"act returned {type(answer).__name__} of type {actions.dtype}; return {wanted}")
        if actions.shape != (episodes, 2):
            raise self.fail(f"act returned shape {actions.shape}; return {wanted}")
        return actions.astype(np.float32)


def wrong_action(actions: Float[np.ndarray, "2 episode"], playing: np.ndarray) -> tuple[int, str] | None:
    """Return the first ``playing`` episode with an impossible action, and what is wrong; None if all are possible."""
    for episode in np.flatnonzero(playing & ~np.asarray(ACTION.contains(actions)))[:1]:
        acceleration, steering = actions[:, episode]
        finite = np.isfinite(acceleration + steering)
        hint = "clip it if that is intended" if finite else "check for a division by zero or a missing value"
        return int(episode), f"act returned [{acceleration:g} {steering:g}], not {ACTION}; {hint}"
    return None


class _RaisedError(Exception):
    """A function of the driver raised ``cause``."""

    def __init__(self, cause: BaseException) -> None:
        self.cause = cause


class _Thread:
    """Calls functions in a thread of its own. After a call that takes too long, it abandons the thread."""

    def __init__(self) -> None:
        self._queues: tuple[SimpleQueue[Any], SimpleQueue[Any]] | None = None

    def call(self, function: Callable[..., Any], arguments: tuple[Any, ...], seconds: float) -> Any:
        """Return the function's result. Raises _RaisedError if it raises, TimeoutError if it takes too long."""
        if self._queues is None:
            self._queues = SimpleQueue(), SimpleQueue()
            threading.Thread(target=_serve, args=self._queues, daemon=True).start()  # a daemon doesn't delay the exit
        calls, results = self._queues
        calls.put((function, arguments))
        try:
            result, error = results.get(timeout=seconds)
        except Empty:
            self._queues = None
            raise TimeoutError from None
        except BaseException:  # Ctrl-C: a late result must not be taken for the answer to the next call
            self._queues = None
            raise
        if error is not None:
            raise _RaisedError(error)
        return result


def _serve(calls: SimpleQueue[Any], results: SimpleQueue[Any]) -> None:
    """Make each call that arrives. Its result is (value, None) or (None, error)."""
    while True:
        function, arguments = calls.get()
        try:
            results.put((function(*arguments), None))
        except BaseException as error:  # SystemExit would also end the thread and leave the caller waiting
            results.put((None, error))


def _described(error: BaseException) -> str:
    """Describe an error, for example ``ZeroDivisionError: division by zero (mine.py, line 12)``."""
    last = traceback.extract_tb(error.__traceback__)[-1:]
    where = "".join(f" ({Path(frame.filename).name}, line {frame.lineno})" for frame in last)
    return shorten(f"{type(error).__name__}: {error}", MESSAGE) + where
