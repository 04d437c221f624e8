"""``jaxwalk sweep``."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import Sweep
from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.sweep_page import shown_value
from jaxwalk.sweeps.sweep_results import SweepResults
from jaxwalk.sweeps.sweeping import sweep

BEST = 3
"""Number of trials that are named at the end."""


def run(options: Sweep) -> int:
    """Work on the sweep until nothing is left for this process; return 130 if Ctrl-C ended it."""
    if options.example:
        print(resources.files("jaxwalk.sweeps").joinpath("example.toml").read_text(encoding="utf-8"), end="")
        return 0
    if options.study is None:
        raise UsageError("name the file of the sweep; jaxwalk sweep --example prints one")
    plan = load_sweep(options.study)
    return until_interrupted(lambda: said(sweep(options.out, plan), options.out))


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
