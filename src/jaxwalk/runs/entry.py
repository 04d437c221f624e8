"""``jaxwalk.train`` and ``jaxwalk.resume``: a training from Python. The command ``jaxwalk train`` is made of them.

In a program that several processes run (`jax.distributed`), all call one of them with a folder that all see; what the
first process says counts, and it alone writes and calls ``on_update``.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from tempfile import mkdtemp

from rich.console import Console

from jaxwalk.evaluation import SAMPLES, with_mode
from jaxwalk.interfaces import Roles
from jaxwalk.peers import is_first, several
from jaxwalk.policies import LearnedPolicy, load_policy, read_metadata
from jaxwalk.recipes import RECIPES, Experiment, ExperimentFileError, load_experiment, with_training
from jaxwalk.runs.folder import Run, RunError, check_writable
from jaxwalk.runs.progress import Display
from jaxwalk.runs.session import OnUpdate
from jaxwalk.runs.street import make_street, shared_out, whole_minibatches
from jaxwalk.runs.training import CHECKPOINT_MINUTES, TrainingEnd, meet, train_in
from jaxwalk.shards import mesh_of


@dataclass(frozen=True)
class Upkeep:
    """What is done beside a training, without a change of what it learns."""

    console: Console | None = None
    """Where progress is shown. None: on standard error; ``Console(quiet=True)`` shows nothing."""
    watch: bool = False
    """Whether to write ``watch.html`` into the run folder, a page that shows the progress."""
    checkpoint_minutes: float = CHECKPOINT_MINUTES
    """Minutes between checkpoints."""

    def display(self, experiment: Experiment) -> Display:
        """Return how the progress of an experiment's training is shown."""
        name = "single-agent" if experiment.single_agent else "co-trained"
        return Display(self.console or Console(stderr=True), name, self.watch)


@dataclass(frozen=True)
class Trained(TrainingEnd):
    """A training that has ended, and what came of it."""

    folder: Path | None = None
    """The run folder; None if it was a temporary one."""
    policies: Roles[LearnedPolicy] = field(default_factory=dict)
    """The trained policy of each role that learned, as it acts in an evaluation."""
    metrics: tuple[Mapping[str, int | float], ...] = ()
    """The lines of ``metrics.jsonl``, one for each update."""


def train(
    recipe: str | Path | Experiment = "fast",
    folder: str | Path | None = None,
    *,
    seed: int | None = None,
    updates: int | None = None,
    on_update: OnUpdate | None = None,
    upkeep: Upkeep | None = None,
) -> Trained:
    """Train a recipe, the training of a TOML file, or an `Experiment`.

    The first Ctrl-C ends it after the update in progress, as ``on_update`` can; `resume` continues what is in a folder
    of your own. An exception of ``on_update`` passes through; that folder keeps the checkpoints before it.

    Args:
        recipe: a recipe's name, a file (``docs/recipes.md``), or an `Experiment`, which is trained exactly as it is.
            The environments of the others are shared out among the devices that JAX has.
        folder: a new run folder for configuration, metrics, checkpoints and the policy. None: a temporary one, which is
            removed at the end; where numbers diverge or can't be written, it stays, and the message names it.
        seed: the seed of networks, scenarios and actions. None: the recipe's.
        updates: how many updates to make. None: the recipe's number, or its minutes.
        on_update: is called with the metrics of each update: ``update``, ``seconds``, ``steps``, ``goal_rate``,
            ``collision_rate`` and all others of ``metrics.jsonl``. If it returns True, the training ends after the
            update in progress, about which it is told too. Return None to go on.
        upkeep: how progress is shown, and how often checkpoints are written.

    Raises:
        ValueError: no such recipe, an impossible seed or number of updates, a wrong file or map. The message names it.
        RunError: the folder isn't empty or can't be written (before the training); `DivergedError`, `UnwrittenError`,
            `PeerLostError`.
        CallbackError: ``on_update`` returned something else than None or a truth value.
    """
    if several() and folder is None:
        raise RunError("folder: several processes train together in a folder that all of them see; name one")
    if not is_first():
        return _follow(Path(str(folder)))
    experiment = _experiment(recipe, seed, updates)
    street = make_street(experiment)
    mesh_of(experiment.train.shards)
    upkeep = upkeep or Upkeep()
    with _temporary() if folder is None else nullcontext(Path(folder)) as path:
        run = Run.create(path, experiment, street.maps)
        meet()
        ended = train_in(
            run, street=street, on_update=on_update, display=upkeep.display(experiment),
            checkpoint_minutes=upkeep.checkpoint_minutes,
        )  # fmt: skip
        return _trained(run, ended, kept=folder is not None)


def resume(folder: str | Path, *, on_update: OnUpdate | None = None, upkeep: Upkeep | None = None) -> Trained:
    """Continue the training of a run folder, with its own configuration; a finished one changes no more.

    Args:
        folder: the run folder. Its newest checkpoint that can be read is where the training goes on.
        on_update: as in `train`; it is told of updates after the checkpoint only.
        upkeep: as in `train`.

    Raises:
        RunError: no such folder, another process trains there, or its configuration was edited; `DivergedError`,
            `UnwrittenError`, `PeerLostError`.
        CallbackError: as in `train`.
    """
    if not is_first():
        return _follow(Path(folder))
    run, upkeep = Run.open(folder), upkeep or Upkeep()
    street = make_street(run.experiment, run.maps(), run.archives)
    mesh_of(run.experiment.train.shards)
    check_writable(run.path)
    meet()
    ended = train_in(
        run, resume=True, street=street, on_update=on_update, display=upkeep.display(run.experiment),
        checkpoint_minutes=upkeep.checkpoint_minutes,
    )  # fmt: skip
    return _trained(run, ended, kept=True)


def _follow(folder: Path) -> Trained:
    """Train in the folder that the first process makes or resumes."""
    meet()
    run = Run.open(folder)
    street = make_street(run.experiment, run.maps(), run.archives)
    return _trained(run, train_in(run, resume=True, street=street), kept=True)


def _experiment(recipe: str | Path | Experiment, seed: int | None, updates: int | None) -> Experiment:
    """Return the experiment to train, with another seed and number of updates if these are given."""
    experiment = _named(recipe)
    if updates is not None:
        experiment = replace(with_training(experiment, updates=updates), minutes=None)
    return experiment if seed is None else replace(experiment, seed=seed)


def _named(recipe: str | Path | Experiment) -> Experiment:
    """Return the experiment of a name or a file, with its environments shared out; an `Experiment` itself as it is."""
    if isinstance(recipe, Experiment):
        return recipe
    if recipe in RECIPES:
        return shared_out(RECIPES[str(recipe)])
    if not Path(recipe).exists():
        raise ExperimentFileError(f"{recipe}: no recipe of that name ({', '.join(RECIPES)}) and no file; check it")
    found = load_experiment(recipe, RECIPES)
    return whole_minibatches(found) if found.train.shards > 1 else shared_out(found)


@contextmanager
def _temporary() -> Iterator[Path]:
    """Yield a temporary folder. It is removed, unless the training fails in a way that leaves something to look at."""
    path = Path(mkdtemp(prefix="jaxwalk-"))
    try:
        yield path
    except RunError:
        raise
    except BaseException:
        shutil.rmtree(path, ignore_errors=True)
        raise
    shutil.rmtree(path)


def _trained(run: Run, ended: TrainingEnd, *, kept: bool) -> Trained:
    """Return how a training ended, with what its folder holds."""
    roles = read_metadata(run.policy)["roles"]
    policies = {role: with_mode(load_policy(run.policy, role), sample=SAMPLES[role]) for role in roles}
    return Trained(**asdict(ended), folder=run.path if kept else None, policies=policies, metrics=tuple(run.metrics()))
