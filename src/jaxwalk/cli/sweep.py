"""``jaxwalk sweep``."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import Sweep
from jaxwalk.cli.sweep_jobs import LOGS, check_place, run_on_ray, submit_jobs
from jaxwalk.sweeps.drawn_trials import shown_value
from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.sweep_results import SweepResults
from jaxwalk.sweeps.sweeping import begin_sweep, sweep

BEST = 3
"""Number of trials that are named at the end."""


def run(options: Sweep) -> int:
    """Work on the sweep until nothing is left for this process; return 130 if Ctrl-C ended it."""
    if options.example:
        print(resources.files("jaxwalk.sweeps").joinpath("example.toml").read_text(encoding="utf-8"), end="")
        return 0
    if options.study is None:
        raise UsageError("name the file of the sweep; jaxwalk sweep --example prints one")
    check_place(options)
    plan = load_sweep(options.study)
    if options.on != "local":
        begin_sweep(options.out, plan)
    if options.on == "slurm":
        return _submitted(options)
    if options.on == "ray":
        run_on_ray(options)
    return until_interrupted(lambda: said(sweep(options.out, plan), options.out))


def _submitted(options: Sweep) -> int:
    """Submit jobs, and say which."""
    jobs = ", ".join(str(job.job_id) for job in submit_jobs(options))
    print(f"Submitted to SLURM: {jobs}; their output is in {options.out / LOGS}")
    print(
        f"Each job writes {options.out / 'study.html'}. When they have ended, the same command without --on says which"
    )
    print("trials are the best, or goes on here; with --on slurm, it submits further jobs.")
    return 0


def said(results: SweepResults, folder: Path) -> str:
    """Return in words what came of a sweep so far."""
    lines = [results.in_words()]
    if results.left:
        lines.append(f"Left: {results.left}; other processes work on them, or the same command goes on with them.")
    best, objective = results.best, results.plan.objective
    for trial in best[:BEST]:
        values = ", ".join(f"{name} {shown_value(value)}" for name, value in trial.values.items())
        lines.append(f"trial {trial.number}: {objective.metric} {shown_value(trial.value)}; {values}")
    if best:
        run = folder / "trials" / str(best[0].number) / next(iter(best[0].seeds))
        lines.append(
            f"The best of {len(best)} is partly lucky, so its number is optimistic: evaluate it on scenarios of a "
            "seed that nothing was chosen by:"
        )
        lines.append(f"jaxwalk evaluate --driver {run} --seed 1234 --episodes 2000")
    return "\n".join([*lines, f"Open {folder / 'study.html'}"])
