"""Options of the commands that train."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from jaxwalk.cli.options.declare import Flag, PaperRecipe, Recipe, World, option, tuned


@dataclass(frozen=True)
class Train:
    """Train a car and its pedestrians, or resume a training that was interrupted.

    For example: jaxwalk train --run runs/first --minutes 4
    """

    run_folder: Annotated[Path | None, option("none; needed unless --resume", "DIR", "run")] = None
    """New folder for configuration, metrics, checkpoints and the policy."""
    resume: Annotated[Path | None, option("none", "DIR")] = None
    """Resume the training in this run folder, with its own configuration."""
    recipe: Recipe = "fast"
    """fast: whatever learns best; paper: the paper's networks, rewards and numbers; town: fast on 64 generated streets,
    in the world town; blind-corner: the same where people are hidden, -lagrangian with limits of contacts, -cvar of the
    speed in the worst ones."""
    config: Annotated[Path | None, option("none", "FILE")] = None
    """Instead of --recipe, a TOML file that names a recipe and changes any of its fields (docs: recipes). Other
    options change what the file says."""
    seed: Annotated[int | None, option("the recipe's: 0", "N")] = None
    """Seed of networks, scenarios and actions."""
    updates: Annotated[int | None, tuned("updates", "N")] = None
    """Number of updates."""
    minutes: Annotated[float | None, option("none", "MIN")] = None
    """Instead, plan as many updates as this machine makes in this time."""
    single_agent: Flag = False
    """Train the car alone, among pedestrians who always go."""
    map: Annotated[tuple[str, ...], option("the recipe's: paper; town training:64", "MAP [MAP ...]")] = ()
    """Bundled maps, map files, or generated streets, such as training:64, to train on (docs: streets)."""
    world: Annotated[World | None, option("the recipe's, by footprint on other maps than paper", "WORLD")] = None
    """What a collision is. paper: the centres closer than 1.5 m; paper-footprint: a body touches the car; campus:
    that too, a slow car, and people at a measured pace (docs: real-recordings); town: as paper-footprint, and a car
    for towns (50 km/h, harder brakes, slower in bends); blind-corner and arterial: that too, and people are hidden, and
    many run (docs: perception)."""
    jaywalk_multiplier: Annotated[float | None, option("the world's", "X")] = None
    """P(jaywalk | decision) = jaywalking tendency x this: 1 where people are hidden, else 0.25."""
    archive: Annotated[tuple[str, ...] | None, option("none", "PATH [PATH ...]")] = None
    """Files of scenarios, or folders of `jaxwalk search`, found on these maps and in this world: mixed into the
    episodes with as many people (docs: learning-from-failures)."""
    archive_share: Annotated[float | None, option("0.25", "X")] = None
    """Share of these episodes that begin with one of the scenarios of --archive."""
    environments: Annotated[int | None, tuned("environments", "N")] = None
    """Environments side by side (fast with --single-agent: 512)."""
    steps: Annotated[int | None, tuned("steps", "N")] = None
    """Steps of 0.1 s that each environment makes in an update."""
    minibatches: Annotated[int | None, tuned("minibatches", "N")] = None
    """Parts into which an epoch divides the steps of an update."""
    learning_rate: Annotated[float | None, tuned("learning_rate", "X")] = None
    """Adam's step size."""
    discount: Annotated[float | None, tuned("discount", "X")] = None
    """Worth now of a reward one step (0.1 s) later."""
    gae_lambda: Annotated[float | None, tuned("gae_lambda", "X")] = None
    """How far advantages look before they trust the critic."""
    clip: Annotated[float | None, tuned("clip", "X")] = None
    """Probability ratios beyond 1 +- this gain nothing more."""
    reward_scale: Annotated[float | None, tuned("reward_scale", "X")] = None
    """The learner sees rewards times this."""
    chunk_rows: Annotated[int | None, tuned("chunk_rows", "N")] = None
    """Rows whose gradient is taken at once: speed only. Small for a processor's cache, 200000 or more for a GPU."""
    shards: Annotated[int | None, option("every core; 1 on an accelerator", "N")] = None
    """Devices (cores or accelerators) among which the environments are shared out. For speed; but with another number a
    training comes out as with another seed."""
    checkpoint_minutes: Annotated[float, option("2", "MIN")] = 2.0
    """Minutes between checkpoints."""
    watch: Flag = False
    """Also write watch.html into the run folder: a page that shows the training's progress in a browser."""
    processes: Annotated[int, option("1", "N")] = 1
    """Number of processes that train together and divide the shards, one for each unless --shards says more. They are
    started on this machine, unless --coordinator is given (docs: beyond-one-machine)."""
    restarts: Annotated[int, option("0", "N")] = 0
    """How often to begin again from the last checkpoint if a process is lost."""
    coordinator: Annotated[str | None, option("none", "HOST:PORT")] = None
    """Where process 0 can be reached, if the processes are started by hand or by a cluster's scheduler."""
    process: Annotated[int | None, option("none", "I")] = None
    """With --coordinator: the number of this process, from 0."""


@dataclass(frozen=True)
class Reproduce:
    """The whole experiment: two trainings, every driver among every population, the ablation and the report.

    About 10 minutes on two CPU cores, and 6 more for each further training seed. Run it again to continue after
    an interruption: what is finished is kept.
    """

    out: Annotated[Path, option("runs/reproduce", "DIR")] = Path("runs/reproduce")
    """Folder for everything; open report.html in it."""
    recipe: PaperRecipe = "fast"
    """Recipe of all trainings. fast: whatever learns best; paper: the paper's, which takes hours, better days."""
    minutes: Annotated[float, option("3", "MIN")] = 3.0
    """Time for the first co-training; all others make as many updates."""
    updates: Annotated[int | None, option("none", "N")] = None
    """Number of updates of each training, instead."""
    episodes: Annotated[int, option("1000", "N")] = 1000
    """Scenarios in each cell."""
    seed: Annotated[int, option("0", "N")] = 0
    """Seed of the scenarios, and the first training seed."""
    seeds: Annotated[int, option("1", "N")] = 1
    """Train both drivers with this many training seeds: seed, seed + 1, and so on; 5 show how much a seed matters."""


@dataclass(frozen=True)
class HiddenIntent:
    """What does it cost a car not to know who is likely to jaywalk, or not to see everybody?

    Trains the car alone several times for each training seed: blind, told something that decides nothing, told what
    could be inferred about people, told their tendencies, and, where people can be hidden, seeing everybody. Each
    training takes 2 to 3 minutes on two CPU cores, among hidden people longer. Run it again to continue after an
    interruption: what is finished is kept.
    """

    out: Annotated[Path, option("runs/hidden-intent", "DIR")] = Path("runs/hidden-intent")
    """Folder for everything; read hidden-intent.md in it."""
    recipe: Literal["fast", "blind-corner"] = "fast"
    """Recipe of all trainings. fast: on the paper's street; blind-corner: where people are hidden, and in a hurry."""
    cars: Annotated[tuple[str, ...], option("all", "CAR [CAR ...]")] = ()
    """Train only these cars: blind and others that the page names."""
    time_weights: Annotated[tuple[float, ...], option("1", "W [W ...]")] = (1.0,)
    """Prices of time, as multiples of the recipe's, 1 among them: train each car with each, and compare cars at equal
    delay (docs: metrics)."""
    pace_correlation: Annotated[float, option("0", "R")] = 0.0
    """How far people's pace tells of their jaywalking tendency, from -1 to 1, in trainings and evaluations
    (docs: people)."""
    only_as_trained: Flag = False
    """Evaluate in the setting of the trainings alone. Without it, the same folder goes on with the others."""
    seeds: Annotated[int, option("5", "N")] = 5
    """Number of training seeds: seed, seed + 1, and so on."""
    updates: Annotated[int, option("200", "N")] = 200
    """Updates of each training."""
    episodes: Annotated[int, option("2000", "N")] = 2000
    """Scenarios for each driver and setting."""
    seed: Annotated[int, option("0", "N")] = 0
    """Seed of the scenarios, and the first training seed."""


@dataclass(frozen=True)
class CoTraining:
    """Does training a car together with people make a better car than training it alone?

    Trains the car five times for each training seed: alone, and with people who learn too; with or without people who
    always go among them, with or without careless cars to teach them. 50 trainings of 2 to 5 minutes on two CPU cores,
    and half an hour of evaluation. Run it again to continue after an interruption: what is finished is kept.
    """

    out: Annotated[Path | None, option("runs/co-training; with --sweep runs/paper-weights", "DIR")] = None
    """Folder for everything; read co-training.md, or paper-weights.md, in it."""
    sweep: Flag = False
    """Instead: vary the weights that the paper leaves open, in recipe paper. Exploratory: five times 80 minutes."""
    seeds: Annotated[int | None, option("10; with --sweep 1", "N")] = None
    """Number of training seeds: seed, seed + 1, and so on; fewer than 5 judge nothing."""
    updates: Annotated[int | None, option("200; with --sweep 400", "N")] = None
    """Updates of each training."""
    episodes: Annotated[int, option("2000", "N")] = 2000
    """Scenarios for each driver and population."""
    seed: Annotated[int, option("40", "N")] = 40
    """Seed of the scenarios, and the first training seed; nothing was tuned on 40."""


@dataclass(frozen=True)
class Generalisation:
    """Does the car cope with streets that it has never seen, and how much do more streets in training help?

    Trains the car of recipe town alone, on 1, 8, 64 and 256 streets with each training seed, and tests all cars and
    three rules on unseen streets, of the same family and of another one, on the paper's street, and among fewer and
    more people. Run it again to continue after an interruption: what is finished is kept.
    """

    out: Annotated[Path, option("runs/generalisation", "DIR")] = Path("runs/generalisation")
    """Folder for everything; read generalisation.md in it."""
    seeds: Annotated[int, option("5", "N")] = 5
    """Number of training seeds: seed, seed + 1, and so on; fewer than 5 judge nothing."""
    updates: Annotated[int, option("400", "N")] = 400
    """Updates of each training."""
    episodes: Annotated[int, option("2000", "N")] = 2000
    """Scenarios for each driver and set of streets."""
    seed: Annotated[int, option("60", "N")] = 60
    """Seed of the scenarios, and the first training seed; nothing was tuned on 60."""


@dataclass(frozen=True)
class RiskAware:
    """Does learning with limits of costs make a car whose worst contacts are slower?

    Trains recipe blind-corner without limits, with limits of contacts (blind-corner-lagrangian) and with one of the
    speed in the worst contacts (blind-corner-cvar), equally long for each training seed, and plays all of them and the
    clearance rule on the same scenarios. Run it again to continue after an interruption: what is finished is kept.
    """

    out: Annotated[Path, option("runs/risk-aware", "DIR")] = Path("runs/risk-aware")
    """Folder for everything; read risk-aware.md in it."""
    seeds: Annotated[int, option("5", "N")] = 5
    """Number of training seeds: seed, seed + 1, and so on; fewer than 5 judge nothing."""
    updates: Annotated[int, option("200", "N")] = 200
    """Updates of each training."""
    episodes: Annotated[int, option("4000", "N")] = 4000
    """Scenarios for each driver; a hundredth of them are the worst ones."""
    seed: Annotated[int, option("90", "N")] = 90
    """Seed of the scenarios, and the first training seed; nothing was tuned on 90."""
