"""``jaxwalk train``."""

from __future__ import annotations

import dataclasses
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from jaxwalk.cli.errors import INTERRUPTED, UsageError, bad_values
from jaxwalk.cli.options import Train
from jaxwalk.peers import leave_together
from jaxwalk.recipes import LONGEST, RECIPES, Experiment, load_experiment, single_agent, with_training
from jaxwalk.runs.entry import Upkeep, resume, train
from jaxwalk.runs.folder import check_new
from jaxwalk.runs.progress import Display
from jaxwalk.runs.street import shared_out, whole_minibatches
from jaxwalk.sim.sim_config import rules_of
from jaxwalk.wording import counted

TUNABLE = (
    "updates", "environments", "steps", "minibatches",
    "learning_rate", "discount", "gae_lambda", "clip", "reward_scale", "chunk_rows", "shards",
)  # fmt: skip
"""Options that are fields of `TrainConfig`."""
GOES_WITH_RESUME = (
    "resume", "checkpoint_minutes", "watch", "processes", "restarts", "coordinator", "process",
)  # fmt: skip
"""The only options that a resumed training takes."""


def run(options: Train) -> int:
    """Train or resume; return 130 if Ctrl-C ended it."""
    code = _follow(options) if options.process else _lead(options)
    leave_together()
    return code


def _follow(options: Train) -> int:
    """Train in the folder that process 0 begins or resumes."""
    folder = options.resume or options.run_folder
    if folder is None:
        raise UsageError("--run DIR or --resume DIR is missing: the folder of process 0")
    return INTERRUPTED if resume(folder).interrupted else 0


def _lead(options: Train) -> int:
    """Train or resume, as process 0 or alone."""
    check(options)
    console = Console(stderr=True)
    upkeep = Upkeep(console, watch=options.watch, checkpoint_minutes=options.checkpoint_minutes)
    if options.resume:
        trained = resume(options.resume, upkeep=upkeep)
    else:
        experiment = make_experiment(options)
        undecided = options.shards is None and experiment.train.shards == 1
        fitted = shared_out(experiment) if undecided else whole_minibatches(experiment)
        trained = train(fitted, options.run_folder, upkeep=upkeep)
    say = Display(console).say
    done = f"{counted(trained.updates, 'update')}, {counted(trained.steps, 'step')}"
    made = f"{done} in {trained.seconds / 60:.1f} minutes"
    if trained.interrupted:
        processes = f" --processes {options.processes}" if options.processes > 1 else ""
        say(f"Interrupted after {made}. Resume with: jaxwalk train --resume {trained.folder}{processes}")
        return INTERRUPTED
    say(f"Trained: {made}. Evaluate with: jaxwalk evaluate --driver {trained.folder}")
    return 0


def check(options: Train) -> None:
    """Raise an error for options that exclude each other, and for a folder that can't be written."""
    for name in ("minutes", "checkpoint_minutes"):
        value = getattr(options, name)
        if value is not None and not 0 < value <= LONGEST:
            raise UsageError(f"--{name.replace('_', '-')} must be above 0 and at most {LONGEST:,}, not {value:g}")
    if options.resume and options.run_folder:
        raise UsageError("--run begins a training, --resume continues one; give one of them")
    if options.resume:
        given = [f.name for f in dataclasses.fields(Train) if getattr(options, f.name) != f.default]
        extra = [name for name in given if name not in GOES_WITH_RESUME]
        if extra:
            name = extra[0].replace("_", "-")
            raise UsageError(f"--{name}: a resumed training keeps its configuration; leave it out, or use --run")
        return
    if options.run_folder is None:
        raise UsageError("--run DIR is missing: where to keep the training (or --resume DIR, to continue one)")
    if options.archive == ():
        raise UsageError("--archive needs a file of scenarios, or the folder of a search")
    if options.minutes is not None and options.updates is not None:
        raise UsageError("--updates and --minutes both say how long to train; give one of them")
    if options.config and options.recipe != Train.recipe:
        raise UsageError("--recipe: the file of --config names the recipe; leave one of them out")
    check_new(options.run_folder)


def make_experiment(options: Train) -> Experiment:
    """Return the recipe, or the training of a file, with the changes that the options ask for."""
    experiment = load_experiment(options.config, RECIPES) if options.config else RECIPES[options.recipe]
    experiment = single_agent(experiment) if options.single_agent else experiment
    with bad_values():
        experiment = with_training(experiment, **{name: getattr(options, name) for name in TUNABLE})
        changes = {
            "seed": options.seed, "maps": tuple(map(_absolute, options.map)) or None,
            "jaywalk_multiplier": options.jaywalk_multiplier,
            "minutes": options.minutes,
            "archives": tuple(str(Path(name).absolute()) for name in options.archive or ()) or None,
            "archive_share": options.archive_share,
        }  # fmt: skip
        experiment = replace(experiment, **{name: value for name, value in changes.items() if value is not None})
        if options.archive_share is not None and not experiment.archives:
            raise UsageError("--archive-share is the share of the scenarios of --archive; name some, or leave it out")
        if options.updates is not None:
            experiment = replace(experiment, minutes=None)
        if options.world or options.map:
            sim = rules_of(options.world, experiment.maps, experiment.sim)
            experiment = replace(experiment, sim=sim)
    return experiment


def _absolute(name: str) -> str:
    """Return a map file's absolute path, so that the run can be resumed from anywhere; a bundled map keeps its name."""
    return str(Path(name).absolute()) if Path(name).is_file() else name
