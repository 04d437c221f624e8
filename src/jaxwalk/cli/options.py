"""The commands and their options. No heavy imports: ``--help`` must answer at once."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from jaxwalk.experiments.recipes import RECIPES


class UsageError(ValueError):
    """Options that don't make sense; one line says why and what to do."""


def _option(default: str, kind: str | None = None, name: str | None = None) -> Any:
    """How ``--help`` shows an option: its default in words, and what to write after it."""
    return tyro.conf.arg(help_behavior_hint=f"(default: {default})", metavar=kind, name=name)


def _tuned(name: str, kind: str) -> Any:
    """An option that is a field of `TrainConfig`: its default is the recipe's."""
    values = ", ".join(f"{recipe} {getattr(experiment.train, name):g}" for recipe, experiment in RECIPES.items())
    return _option(f"the recipe's: {values}", kind)


BenchPart = Literal["env", "train", "compile", "pedestrians"]
"""What `jaxwalk bench` can measure."""
Flag = tyro.conf.FlagCreatePairsOff[bool]
"""An option without a value."""


@dataclass(frozen=True)
class Train:
    """Train a car and its pedestrians, or go on with a training that was interrupted.

    For example: jaxwalk train --run runs/first --minutes 4
    """

    run_folder: Annotated[Path | None, _option("none; needed unless --resume", "DIR", "run")] = None
    """Folder to make for configuration, metrics, checkpoints and the policy."""
    resume: Annotated[Path | None, _option("none", "DIR")] = None
    """Go on with the training in this run folder, as it was configured."""
    recipe: Literal["fast", "paper"] = "fast"
    """fast: whatever learns best; paper: the paper's networks, pay and numbers."""
    seed: Annotated[int, _option("0", "N")] = 0
    """Of networks, scenarios and actions."""
    updates: Annotated[int | None, _tuned("updates", "N")] = None
    """Train so many updates."""
    minutes: Annotated[float | None, _option("none", "MIN")] = None
    """Instead, plan as many updates as fit into so many minutes on this machine."""
    single_agent: Flag = False
    """Train the car alone, among pedestrians who always go."""
    map: Annotated[tuple[str, ...], _option("paper", "MAP [MAP ...]")] = ("paper",)
    """Bundled maps or map files to train on."""
    jaywalk_multiplier: Annotated[float, _option("0.25", "X")] = 0.25
    """P(jaywalk | decision) = jaywalking tendency x this."""
    environments: Annotated[int | None, _tuned("environments", "N")] = None
    """Environments side by side (fast with --single-agent: 512)."""
    steps: Annotated[int | None, _tuned("steps", "N")] = None
    """Steps of 0.1 s that each environment makes in an update."""
    minibatches: Annotated[int | None, _tuned("minibatches", "N")] = None
    """Parts into which an epoch divides the steps of an update."""
    learning_rate: Annotated[float | None, _tuned("learning_rate", "X")] = None
    """Adam's step size."""
    discount: Annotated[float | None, _tuned("discount", "X")] = None
    """Worth now of a reward one step (0.1 s) later."""
    gae_lambda: Annotated[float | None, _tuned("gae_lambda", "X")] = None
    """How far advantages look before they trust the critic."""
    clip: Annotated[float | None, _tuned("clip", "X")] = None
    """Probability ratios beyond 1 +- this gain nothing more."""
    reward_scale: Annotated[float | None, _tuned("reward_scale", "X")] = None
    """The learner sees rewards times this."""
    chunk_rows: Annotated[int | None, _tuned("chunk_rows", "N")] = None
    """Rows whose gradient is taken at once: speed only. Small for a processor's cache, 200000 or more for a GPU."""
    checkpoint_minutes: Annotated[float, _option("2", "MIN")] = 2.0
    """Minutes between checkpoints."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.train import run

        return run(self)


@dataclass(frozen=True)
class Evaluate:
    """How often do drivers reach their goal, and how often do they hit somebody? Every driver meets every population.

    For example: jaxwalk evaluate --driver rule-based runs/first --pedestrians always-go runs/first
    """

    driver: Annotated[tuple[str, ...], _option("needed, unless --compare", "D [D ...]")] = ()
    """Rules (random, constant-speed, rule-based, rule-based-braking, route-follower, oracle), trained policies that
    come with jaxwalk (co-trained, single-agent, paper-co-trained, paper-single-agent), run folders or policy files."""
    pedestrians: Annotated[tuple[str, ...], _option("always-go", "P [P ...]")] = ("always-go",)
    """always-go, learned and paper-learned (who come with jaxwalk), run folders or policy files."""
    compare: Annotated[tuple[str, ...], _option("none", "A B")] = ()
    """Two drivers: say in words whether B collides less than A, and reaches the goal more (paired tests)."""
    episodes: Annotated[int, _option("2000", "N")] = 2000
    """Scenarios in each cell, the same for all."""
    seed: Annotated[int, _option("0", "N")] = 0
    """Which set of scenarios; none is ever met in training."""
    map: Annotated[tuple[str, ...], _option("the run folders', else paper", "MAP [MAP ...]")] = ()
    """Bundled maps or map files."""
    jaywalk_multiplier: Annotated[tuple[float, ...], _option("0.25", "X [X ...]")] = (0.25,)
    """P(jaywalk | decision) = jaywalking tendency x this; several: an evaluation with each."""
    sample_driver: Flag = False
    """A learned driver draws its actions at random, as in training; else it takes the likeliest."""
    pedestrian_mode: Flag = False
    """Learned pedestrians take the likeliest action; else they draw at random, as in training."""
    counterfactuals: Annotated[int, _option("0", "N")] = 0
    """Replay so many collisions of each cell otherwise: who could have avoided them? Some 0.2 s for each."""
    out: Annotated[Path | None, _option("none", "DIR")] = None
    """Folder for results.json (all metrics), suite.md (the same as tables) and episodes.csv (a row per episode)."""
    encounters: Flag = False
    """Also encounters.parquet, a row per encounter (needs --out, and pip install "jaxwalk[data]")."""
    json: Flag = False
    """Print one JSON document instead of the table."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.evaluate import run

        return run(self)


@dataclass(frozen=True)
class Play:
    """Draw one episode, as a picture or an animation.

    For example: jaxwalk play --driver runs/first --pedestrians runs/first --scenario 3 --out episode.gif
    """

    driver: Annotated[str, _option("needed", "D")] = ""
    """As in `jaxwalk evaluate`: a rule, a trained policy that comes with jaxwalk, a run folder or a policy file."""
    pedestrians: Annotated[str, _option("always-go", "P")] = "always-go"
    """always-go, learned, a run folder or a policy file."""
    scenario: Annotated[int, _option("0", "N")] = 0
    """Number of the scenario: a row of an evaluation with the same seed."""
    seed: Annotated[int, _option("0", "N")] = 0
    """Which set of scenarios."""
    map: Annotated[tuple[str, ...], _option("the run folders', else paper", "MAP [MAP ...]")] = ()
    """Bundled maps or map files."""
    jaywalk_multiplier: Annotated[float, _option("0.25", "X")] = 0.25
    """P(jaywalk | decision) = jaywalking tendency x this."""
    out: Annotated[Path, _option("episode.png", "FILE")] = Path("episode.png")
    """.png for a picture, .gif or .mp4 for an animation; an existing file is replaced."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.play import run

        return run(self)


@dataclass(frozen=True)
class Reproduce:
    """The whole experiment: two trainings, every driver among every population, the ablation and the report.

    About 8 minutes on two CPU cores, and 7 more for each further training seed. Run it again to go on where it was
    interrupted: what is finished is kept.
    """

    out: Annotated[Path, _option("runs/reproduce", "DIR")] = Path("runs/reproduce")
    """Folder for everything; open report.html in it."""
    recipe: Literal["fast", "paper"] = "fast"
    """Of all trainings. fast: whatever learns best; paper: the paper's, which wants hours, better days."""
    minutes: Annotated[float, _option("4", "MIN")] = 4.0
    """For the first co-training; all others make as many updates."""
    updates: Annotated[int | None, _option("none", "N")] = None
    """Train so many updates instead."""
    episodes: Annotated[int, _option("1000", "N")] = 1000
    """Scenarios in each cell."""
    seed: Annotated[int, _option("0", "N")] = 0
    """Of the scenarios, and the first training seed."""
    seeds: Annotated[int, _option("1", "N")] = 1
    """Train both drivers with so many training seeds: seed, seed + 1, and so on; 5 show how much a seed matters."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.reproduce import run

        return run(self)


@dataclass(frozen=True)
class Report:
    """Make the report of a `jaxwalk reproduce` folder again: figures, tables and report.html."""

    folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="DIR")] = field()
    """The folder that `jaxwalk reproduce` wrote."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.reproduce import remake

        return remake(self.folder)


@dataclass(frozen=True)
class HiddenIntent:
    """What does it cost a car not to know who is likely to jaywalk, and how much of that could it find out?

    Trains the car alone three times for each training seed: blind, told what could be inferred about people, and told
    their tendencies. Each training takes 2 to 3 minutes on two CPU cores. Run it again to go on where it was
    interrupted: what is finished is kept.
    """

    out: Annotated[Path, _option("runs/hidden-intent", "DIR")] = Path("runs/hidden-intent")
    """Folder for everything; read hidden-intent.md in it."""
    seeds: Annotated[int, _option("5", "N")] = 5
    """Train with so many training seeds: seed, seed + 1, and so on."""
    updates: Annotated[int, _option("200", "N")] = 200
    """Of each training."""
    episodes: Annotated[int, _option("2000", "N")] = 2000
    """Scenarios for each driver and jaywalk multiplier."""
    seed: Annotated[int, _option("0", "N")] = 0
    """Of the scenarios, and the first training seed."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.hidden_intent import run

        return run(self)


@dataclass(frozen=True)
class Share:
    """Make one file of a training's policies to share, which knows its results, and a model card beside it.

    For example: jaxwalk share runs/first --out first.safetensors --pedestrians always-go runs/first
    """

    run_folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="DIR")] = field()
    """The run folder of the training."""
    out: Annotated[Path | None, _option("needed", "FILE")] = None
    """FILE.safetensors; the card is FILE.md. Existing ones are replaced."""
    pedestrians: Annotated[tuple[str, ...], _option("always-go", "P [P ...]")] = ("always-go",)
    """Among whom the driver is evaluated: always-go, learned, run folders or policy files."""
    episodes: Annotated[int, _option("2000", "N")] = 2000
    """Scenarios among each."""
    seed: Annotated[int, _option("0", "N")] = 0
    """Which set of scenarios; none is ever met in training."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.share import run

        return run(self)


@dataclass(frozen=True)
class Bench:
    """How fast is jaxwalk on this machine? Simulator, training, first minute, crowds: some minutes.

    For example: jaxwalk bench --out bench
    """

    only: Annotated[tuple[BenchPart, ...], _option("all", "PART [PART ...]")] = ()
    """env: the simulator alone; train: training and the machine's peak; compile: the first minute; pedestrians: the
    cost of a crowd."""
    quick: Flag = False
    """Few sizes and short times: shows that everything can be measured, and measures little."""
    environments: Annotated[tuple[int, ...], _option("64 to 16384", "N [N ...]")] = ()
    """Environments side by side, a row each, of the simulator alone."""
    training_environments: Annotated[tuple[int, ...], _option("128 512 2048", "N [N ...]")] = ()
    """The same, of training with the recipe fast."""
    pedestrians: Annotated[tuple[int, ...], _option("12 24 48 96", "N [N ...]")] = ()
    """People in an episode, a row each."""
    seconds: Annotated[float | None, _option("3", "S")] = None
    """Measure each row for so long, compiling not included."""
    chunk_rows: Annotated[int | None, _option("the recipe's; on an accelerator a whole minibatch", "N")] = None
    """Rows whose gradient is taken at once in training."""
    seed: Annotated[int, _option("0", "N")] = 0
    """Of scenarios, networks and actions."""
    out: Annotated[Path | None, _option("none", "DIR")] = None
    """Folder for bench.json, bench.md, scaling.svg and scaling.png; files of an earlier time are replaced."""
    json: Flag = False
    """Print one JSON document instead of the table."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.bench import run

        return run(self)


Command = (
    Annotated[Train, tyro.conf.subcommand("train")]
    | Annotated[Evaluate, tyro.conf.subcommand("evaluate")]
    | Annotated[Play, tyro.conf.subcommand("play")]
    | Annotated[Reproduce, tyro.conf.subcommand("reproduce")]
    | Annotated[Report, tyro.conf.subcommand("report")]
    | Annotated[HiddenIntent, tyro.conf.subcommand("hidden-intent")]
    | Annotated[Share, tyro.conf.subcommand("share")]
    | Annotated[Bench, tyro.conf.subcommand("bench")]
)
"""What the command line can ask for."""
