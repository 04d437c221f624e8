"""Parts of an evaluation as tasks of Ray: on all cores of this machine, or of a cluster that runs.

A task plays a part in a temporary folder of its machine and returns its files. So only this process writes what is
kept, no file system has to be shared, and a worker that dies leaves nothing half-written. Nothing here imports JAX: a
worker imports this module before it knows what its JAX is to be like.
"""

from __future__ import annotations

import importlib.util
import logging
import os
import platform
import signal
import socket
import sys
import threading
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

AUTO, LOCAL = "auto", "local"
"""Words for clusters: the one that Ray finds, and one of this machine alone, for as long as the command runs."""
PATIENCE = 10.0
"""Time that the address of a cluster has to answer [s]."""
ATTEMPTS = 4
"""A part is given up when this number of workers have died while they played it: then it is the part."""
STARTS = 3
"""A Ray of our own is started up to this number of times: each time it gives itself 30 s, too little on a machine that
has much else to do."""
ALONE = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0"}
"""Environment of a Ray of our own. By the second one, on any system, Ray uses the loopback address alone."""

PlayedFiles = dict[str, bytes]
"""The files of a played part, by name."""
Play = Callable[[str], PlayedFiles]
"""Plays the part of a name such as ``3/16``; sent to workers, so it can be pickled, and imports no JAX by that."""


class Died(NamedTuple):
    """The end of a worker that played a part."""

    how: str
    """Ray's word for it."""


class Failed(NamedTuple):
    """Why a part can't be played."""

    where: str
    """Name of the machine."""
    why: str


class ClusterError(ValueError):
    """A cluster can't be used, or can't play a part. The message says why and what to do, in one line."""


def check_ray() -> None:
    """Raise ClusterError if Ray is not installed."""
    if importlib.util.find_spec("ray") is None:
        raise ClusterError('--cluster needs Ray; install it with: pip install "jaxwalk[cluster]"')


@contextmanager
def connected(cluster: str, cores: int) -> Iterator[str | None]:
    """Use a cluster inside the ``with``; yield a folder for temporary files of a Ray of our own, else None.

    What Ray prints goes to standard error meanwhile. Signals are handled as before.

    Args:
        cluster: `AUTO`, `LOCAL` or an address, as in ``ray://host:10001`` and ``host:6379``.
        cores: how many tasks a Ray of our own plays at once.

    Raises:
        ClusterError: there is no such cluster, Ray can't start, or isn't installed.
    """
    check_ray()
    if cluster == LOCAL:
        os.environ.update(ALONE)
    with TemporaryDirectory(prefix="jaxwalk-", ignore_cleanup_errors=True) as folder, redirect_stdout(sys.stderr):
        own = {"num_cpus": cores, "include_dashboard": False, "_temp_dir": folder} if cluster == LOCAL else {}
        with _ray(cluster, own):
            yield folder if cluster == LOCAL else None


@contextmanager
def _ray(cluster: str, own: dict[str, Any]) -> Iterator[None]:
    """Use a cluster inside the ``with``; ``own``: options of one of our own. Raise ClusterError as `connected`."""
    import ray  # pyright: ignore[reportMissingImports]

    try:
        with _as_before(), _explained(cluster):
            _check_answers(cluster)
            _start(STARTS if own else 1, address=cluster, **own)
        yield
    finally:
        ray.shutdown()


def _start(attempts: int, **options: Any) -> None:
    """Connect to Ray, or start one, as its own ``init`` does. Raises what that raises at the last attempt."""
    import ray  # pyright: ignore[reportMissingImports]

    try:
        ray.init(log_to_driver=False, logging_level=logging.ERROR, **options)
    except Exception:
        ray.shutdown()
        if attempts == 1:
            raise
        _start(attempts - 1, **options)


def _check_answers(cluster: str) -> None:
    """Raise OSError or ValueError if nobody listens at the address of a cluster, for which Ray would wait minutes."""
    address = (os.environ.get("RAY_ADDRESS") or AUTO) if cluster == AUTO else cluster
    if address in (AUTO, LOCAL):
        return
    host, _, port = address.removeprefix("ray://").rpartition(":")
    socket.create_connection((host.strip("[]"), int(port)), timeout=PATIENCE).close()


@contextmanager
def _as_before() -> Iterator[None]:
    """Let Ray start without what it changes: the handler of SIGTERM; and without a warning about its processes."""
    handler = signal.getsignal(signal.SIGTERM)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", r"os\.fork\(\) was called", RuntimeWarning)  # they run another program
            yield
    finally:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, handler)


@contextmanager
def _explained(cluster: str) -> Iterator[None]:
    """Turn an error of Ray's start into a ClusterError. There are many kinds: of values, connections, libraries."""
    try:
        yield
    except Exception as error:
        found = os.environ.get("RAY_ADDRESS")
        where = f"--cluster {cluster}" + (f" (RAY_ADDRESS={found})" if cluster == AUTO and found else "")
        advice = {
            AUTO: "start one with ray start --head, set RAY_ADDRESS, or take --cluster local",
            LOCAL: "check Ray's installation, and that the folder for temporary files has room and a short name",
        }.get(cluster, "check the address, and that both sides have the same versions of Python and Ray")
        raise ClusterError(f"{where}: can't be used ({_first_line(error)}); {advice}") from error


def cores_of_cluster() -> int:
    """Return how many cores the connected cluster has now."""
    import ray  # pyright: ignore[reportMissingImports]

    return int(ray.cluster_resources().get("CPU", 0))


def play_on_ray(
    play: Play, parts: Iterable[str], keep: Callable[[str, PlayedFiles], None], say: Callable[[str], None]
) -> None:
    """Play parts as tasks of the connected cluster, one for each core at a time.

    A part whose worker died, or whose machine did, is played again, up to `ATTEMPTS` times in all.

    Args:
        play: plays a part.
        parts: their names.
        keep: called in this process with the name and files of each part that was played, in any order.
        say: called with a line about each worker that died.

    Raises:
        ClusterError: a part fails, or its workers die again and again. Nothing is playing any more.
    """
    tasks = Tasks(play, say)
    try:
        for part in parts:
            tasks.begin(part)
        for part, files in tasks.finished():
            keep(part, files)
    except ConnectionError as error:
        raise ClusterError(f"the cluster is gone ({_first_line(error)}); start it again") from error
    finally:
        tasks.end()


class Tasks:
    """Parts that the connected cluster plays, or will."""

    def __init__(self, play: Play, say: Callable[[str], None]) -> None:
        """Have no part yet; the arguments are those of `play_on_ray`."""
        import ray  # pyright: ignore[reportMissingImports]

        # Ray itself would retry silently, and for ever where memory is short.
        self._task = ray.remote(num_cpus=1, max_retries=0)(_played)
        self._play, self._say = play, say
        self._attempts: Counter[str] = Counter()
        self._playing: dict[Any, str] = {}

    def begin(self, part: str) -> None:
        """Let a part be played as soon as there is a core for it."""
        self._attempts[part] += 1
        self._playing[self._task.remote(self._play, part)] = part

    def finished(self) -> Iterator[tuple[str, PlayedFiles]]:
        """Yield name and files of each part as soon as it is played. Raise ClusterError as `play_on_ray` does."""
        import ray  # pyright: ignore[reportMissingImports]

        while self._playing:
            reference = ray.wait([*self._playing])[0][0]
            part = self._playing.pop(reference)
            found = _result(reference, part, self._attempts[part])
            if isinstance(found, Died):
                self._say(f"part {part}: its worker died ({found.how}); it is played again")
                self.begin(part)
            else:
                yield part, found

    def end(self) -> None:
        """End what is still playing."""
        import ray  # pyright: ignore[reportMissingImports]

        for reference in self._playing:
            with suppress(Exception):  # it may have ended meanwhile, or the cluster with it
                ray.cancel(reference, force=True)


def _played(play: Play, part: str) -> PlayedFiles | Failed:
    """Return the files of a part, which is played in the process that calls this: the task. An error is returned too.

    Not every error can be sent as it is.
    """
    try:
        return play(part)
    except Exception as error:
        ours = type(error).__module__.startswith("jaxwalk")
        return Failed(platform.node(), str(error) if ours else f"{type(error).__name__}: {_first_line(error)}")


def _result(reference: Any, part: str, attempt: int) -> PlayedFiles | Died:
    """Return the files of a part that was played, or how its worker died.

    Raise ClusterError if the part fails, or has had its attempts.
    """
    import ray  # pyright: ignore[reportMissingImports]
    from ray.exceptions import RayError, RayTaskError  # pyright: ignore[reportMissingImports]

    try:
        found: Any = ray.get(reference)
    except RayTaskError as error:
        said = str(error).strip().splitlines()[-1]
        advice = "install the same jaxwalk, in the same Python, on all machines"
        raise ClusterError(f"part {part}: a worker can't begin it ({said}); {advice}") from error
    except RayError as error:
        how = type(error).__name__
        if attempt < ATTEMPTS:
            return Died(how)
        advice = "if memory was short, give Ray fewer cores (ray start --num-cpus N)"
        why = f"{ATTEMPTS} workers died while they played it, the last by {how}"
        raise ClusterError(f"part {part}: {why}; {advice}") from error
    if isinstance(found, Failed):
        raise ClusterError(f"part {part} failed on {found.where}: {found.why}")
    return found


def _first_line(error: Any) -> str:
    """Return the first line of an error's text, or its kind if it has none."""
    return next(iter(str(error).strip().splitlines()), type(error).__name__)
