"""A process among several that train together: what its options say, and how it joins the others."""

from __future__ import annotations

import os
import socket
import sys
import threading
from contextlib import suppress
from dataclasses import dataclass

from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import Train
from jaxwalk.recipes import RECIPES, load_experiment
from jaxwalk.runs.folder import Run
from jaxwalk.runs.watchdog import LAUNCHED

MOST = 4096
"""Largest number of processes."""
SILENCE = 30
"""A process that gives no sign of life for so long has stopped: the others end [s]."""
BEAT = 1.0
"""Time between two signs of life that a process gives to its launcher [s]."""
FAREWELL = 60
"""Longest time that a process waits for the others in the end [s]."""
LOOPBACK = ("127.0.0.1", "localhost")


@dataclass(frozen=True)
class Group:
    """Processes that train together, and which of them this one is."""

    coordinator: str
    """Address and port where process 0 can be reached."""
    process: int
    """Number of this process, from 0."""
    processes: int
    devices: int
    """Number of devices of each process: training shards divided by processes."""


def check_processes(options: Train) -> None:
    """Raise UsageError if the options about processes exclude each other or make no sense."""
    if not 1 <= options.processes <= MOST:
        raise UsageError(f"--processes must be from 1 to {MOST:,}, not {options.processes}")
    if (options.coordinator is None) != (options.process is None):
        raise UsageError("--coordinator and --process go together: where process 0 is, and which one this is")
    if options.process is not None and not 0 <= options.process < options.processes:
        raise UsageError(f"--process must be from 0 to {options.processes - 1} (--processes {options.processes})")
    host, _, port = (options.coordinator or "localhost:1").rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise UsageError(f"--coordinator must be HOST:PORT, as in node1:7777, not {options.coordinator}")
    by_others = options.coordinator is not None and LAUNCHED not in os.environ
    if options.restarts < 0 or (options.restarts and (options.processes == 1 or by_others)):
        raise UsageError("--restarts needs processes that this command starts: --processes, without --coordinator")
    if options.processes > 1 and sys.platform == "win32":
        raise UsageError("--processes: JAX's processes don't find each other on Windows; leave it out, or use WSL")


def launches(options: object) -> bool:
    """Return whether a command starts processes, and trains in none itself."""
    return isinstance(options, Train) and options.processes > 1 and options.coordinator is None


def group_of(options: object) -> Group | None:
    """Return the group that the process belongs to; None if it is alone.

    Raises:
        UsageError: options about processes make no sense, or don't divide the shards.
        RunError: the run folder to resume can't be read.
    """
    if not isinstance(options, Train):
        return None
    check_processes(options)
    if options.coordinator is None or options.process is None or options.processes == 1:
        return None
    shards = shards_of(options)
    return Group(options.coordinator, options.process, options.processes, shards // options.processes)


def shards_of(options: Train) -> int:
    """Return the number of shards of a training by several processes. Raises UsageError if they can't divide it."""
    if options.resume:
        shards = Run.open(options.resume).experiment.train.shards
    else:
        experiment = load_experiment(options.config, RECIPES) if options.config else RECIPES[options.recipe]
        stated = options.shards or experiment.train.shards
        shards = stated if stated > 1 else options.processes
    if shards % options.processes:
        raise UsageError(f"--processes must divide the training's {shards} shards, not be {options.processes}")
    return shards


def join(group: Group) -> None:
    """Connect this process with the others; they wait for each other here.

    On Linux its threads don't interrupt each other: the one that watches the connections would, all the time.
    """
    import jax

    if hasattr(os, "SCHED_BATCH"):
        with suppress(OSError):  # a container may forbid it
            os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))  # threads that begin later do as this one
    host, _, port = group.coordinator.rpartition(":")
    jax.config.update("jax_enable_preemption_service", False)  # it would take SIGTERM, which we act on ourselves
    first, launched = group.process * group.devices, LAUNCHED in os.environ
    jax.distributed.initialize(
        group.coordinator, group.processes, group.process,
        local_device_ids=list(range(first, first + group.devices)) if launched else None,
        cluster_detection_method="deactivate",  # it would guess from variables of SLURM, which may be incomplete
        coordinator_bind_address=f"127.0.0.1:{port}" if host in LOOPBACK else None,
        heartbeat_timeout_seconds=4 * SILENCE if launched else SILENCE,  # the launcher is quicker, and has better words
        shutdown_timeout_seconds=FAREWELL,
    )  # fmt: skip


def take_cores(group: Group) -> None:
    """Keep the threads of this process on cores of its own, if a command has started all processes on this machine.

    Each process has as many threads as the machine has cores, since their number decides how sums are rounded: on the
    same cores those of several processes would wait for each other. Only Linux can do it. Call it when JAX has started.
    """
    if LAUNCHED not in os.environ or not hasattr(os, "sched_setaffinity"):
        return
    cores = sorted(os.sched_getaffinity(0))
    if group.processes > len(cores):
        return
    first, end = (number * len(cores) // group.processes for number in (group.process, group.process + 1))
    for thread in os.listdir("/proc/self/task"):
        with suppress(OSError):  # it has ended meanwhile, or a container forbids it
            os.sched_setaffinity(int(thread), cores[first:end])


def keep_in_touch() -> None:
    """Show the process that launched this one that it lives, and end as soon as that has ended.

    Standard input is a socket, whose other end the launcher holds.
    """
    if LAUNCHED in os.environ:
        threading.Thread(target=_keep_in_touch, args=(socket.socket(fileno=os.dup(0)),), daemon=True).start()


def _keep_in_touch(launcher: socket.socket) -> None:
    launcher.settimeout(BEAT)
    with suppress(OSError):
        while _is_there(launcher):
            pass
    os._exit(1)


def _is_there(launcher: socket.socket) -> bool:
    """Send a sign of life and wait a second; return whether the launcher is still there."""
    try:
        launcher.send(b".")
        return bool(launcher.recv(1))
    except TimeoutError:
        return True
