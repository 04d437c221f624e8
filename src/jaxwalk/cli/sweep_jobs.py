"""Processes of a sweep elsewhere: jobs of SLURM, tasks of Ray. Each does what the command does on one machine.

They share the sweep's folder and nothing else, so a job or a task that dies leaves an interrupted trial, which the next
one resumes; it is submitted again, by SLURM (or the user) and by Ray.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from jaxwalk.cli.errors import UsageError, message
from jaxwalk.cli.jax_start import DEVICES
from jaxwalk.cli.options import Sweep
from jaxwalk.experiments.on_ray import AUTO, LOCAL, ClusterError, connected
from jaxwalk.provenance import cores

CLUSTER = "slurm"
"""Submitit's name of the cluster."""
LOGS = "jobs"
"""Folder of the jobs' outputs, inside the sweep's."""
LOGGING = "SUBMITIT_LOG_LEVEL"
"""Submitit's environment variable of what it logs; jobs have the user's."""
RETRIES = 20
"""How often Ray begins a task again whose process or machine died."""
NEEDS = {
    "slurm": ("submitit", 'needs submitit; install it with: pip install "jaxwalk[sweep]"'),
    "ray": ("ray", 'needs Ray; install it with: pip install "jaxwalk[cluster]"'),
}
"""The package that each place needs, and what to do without it."""


class SweepJobError(ValueError):
    """A process of a sweep ended with an error. The message is that of the process."""


@dataclass(frozen=True)
class SweepJob:
    """One process of a sweep, which submitit pickles."""

    study: Path
    out: Path
    """Both absolute, as the machine's working folder may be another one."""
    cpus: int
    """Cores of the process."""

    def __call__(self) -> int:
        """Work on the sweep until nothing is left for this process; return the command's exit code."""
        from jaxwalk.cli.commands import run

        os.environ[DEVICES] = str(self.cpus)  # jobs may have the number of the machine where they were submitted
        return run(Sweep(study=self.study, out=self.out))

    def checkpoint(self, *_: Any) -> Any:
        """Return what to submit when SLURM ends the job before its time: the same, which resumes its trial."""
        return _submitit().helpers.DelayedSubmission(self)


def check_place(options: Sweep) -> None:
    """Raise UsageError unless processes can be started where the options ask for."""
    given = [name for name in ("workers", "cpus", "gpus", "slurm") if getattr(options, name) != getattr(Sweep, name)]
    if options.on == "local" and given:
        raise UsageError(f"--{given[0]} goes with --on slurm or ray; here, run the same command several times")
    for name, least in (("workers", 1), ("cpus", 1), ("gpus", 0)):
        if not least <= getattr(options, name) <= 10_000:
            raise UsageError(f"--{name} must lie in [{least}, 10,000], not {getattr(options, name):,}")
    if options.slurm and options.on != "slurm":
        raise UsageError("--slurm goes with --on slurm")
    if options.on in NEEDS and importlib.util.find_spec(NEEDS[options.on][0]) is None:
        raise UsageError(f"--on {options.on} {NEEDS[options.on][1]}")
    if options.on == "slurm" and CLUSTER == "slurm" and shutil.which("srun") is None:
        raise UsageError("--on slurm: there is no srun on this machine; submit from a login node of the cluster")
    if options.on == "slurm":
        with TemporaryDirectory() as elsewhere:  # a wrong parameter is refused before anything is written
            _executor(options, Path(elsewhere))


def submit_jobs(options: Sweep) -> list[Any]:
    """Submit the processes to SLURM as one array, and return submitit's jobs."""
    executor = _executor(options, options.out / LOGS)
    with executor.batch():
        return [executor.submit(_job(options)) for _ in range(options.workers)]


def _executor(options: Sweep, folder: Path) -> Any:
    """Return what submits jobs, with a folder for their output.

    Raises UsageError for a parameter that submitit doesn't know.
    """
    executor, parameters = _submitit().AutoExecutor(folder=folder, cluster=CLUSTER), _parameters(options)
    try:
        executor.update_parameters(
            name="jaxwalk-sweep", cpus_per_task=options.cpus, gpus_per_node=options.gpus,
            slurm_array_parallelism=options.workers, **parameters,
        )  # fmt: skip
    except (AssertionError, NameError, ValueError, TypeError) as error:
        raise UsageError(f"--slurm: {str(error).splitlines()[0]}; see submitit's parameters") from error
    return executor


def _submitit() -> Any:
    """Return submitit, imported without its logging: that would close all handlers of the process."""
    before = os.environ.get(LOGGING)
    os.environ[LOGGING] = "NOCONFIG"
    try:
        import submitit
    finally:
        os.environ.pop(LOGGING) if before is None else os.environ.update({LOGGING: before})
    return submitit


def _parameters(options: Sweep) -> dict[str, Any]:
    """Return submitit's parameters from words such as ``slurm_partition=long`` and ``timeout_min=240``."""
    found: dict[str, Any] = {}
    for word in options.slurm:
        name, equals, value = word.partition("=")
        if not (name and equals and value):
            raise UsageError(f"--slurm {word}: write KEY=VALUE, such as timeout_min=240 or slurm_partition=long")
        found[name] = int(value) if value.isdecimal() else value
    return found


def _job(options: Sweep) -> SweepJob:
    """Return what one process does."""
    return SweepJob(Path(options.study or "").absolute(), options.out.absolute(), options.cpus)


def run_on_ray(options: Sweep) -> None:
    """Run the processes as tasks of Ray, and wait for them: on the cluster of RAY_ADDRESS, else on this machine.

    A task whose process or machine dies is begun again, and resumes the trial. Raises SweepJobError if one fails, and
    ClusterError if the cluster can't be used or has no machine with that many cores or GPUs.
    """
    ray: Any = import_module("ray")
    with connected(AUTO if os.environ.get("RAY_ADDRESS") else LOCAL, cores()):
        _check_room(ray.nodes(), "--cpus", "CPU", options.cpus)
        _check_room(ray.nodes(), "--gpus", "GPU", options.gpus)
        task = ray.remote(_said_of).options(num_cpus=options.cpus, num_gpus=options.gpus, max_retries=RETRIES)
        ended = ray.get([task.remote(_job(options)) for _ in range(options.workers)])
    for said in filter(None, ended):
        raise SweepJobError(said)


def _check_room(nodes: list[dict[str, Any]], option: str, kind: str, asked: int) -> None:
    """Raise ClusterError if no machine has as many of a resource as asked for: Ray would wait for one, for ever."""
    most = max((node["Resources"].get(kind, 0) for node in nodes if node["Alive"]), default=0)
    if asked > most:
        raise ClusterError(f"{option} {asked:g}: no machine of the cluster has that many; the largest has {most:g}")


def _said_of(job: SweepJob) -> str | None:
    """Do a job; return the message of an error, as the driver may lack the packages to read the error itself."""
    try:
        job()
    except Exception as error:
        text = message(error)
        if text is None:
            raise
        return text
    return None
