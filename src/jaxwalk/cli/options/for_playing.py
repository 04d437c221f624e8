"""Options of the commands that play policies: to evaluate, watch, report and share them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from jaxwalk.cli.options.declare import Acting, Flag, ShieldName, Suite, World, option
from jaxwalk.policies.policy_names import ON_THE_FRONTIER
from jaxwalk.policies.shield_names import SHIELD_NAMES


@dataclass(frozen=True)
class Evaluate:
    """How often do drivers reach their goal, and how often do they hit somebody? Every driver meets every population.

    For example: jaxwalk evaluate --driver rule-based runs/first --pedestrians always-go runs/first
    """

    driver: Annotated[tuple[str, ...], option("needed, unless --compare or --again", "D [D ...]")] = ()
    """Rules (random, constant-speed, rule-based, rule-based-braking, route-follower, clearance, cautious,
    careful-human, careful-human-aeb, fuzzy-safety, crosswalk-yield, idm-yield, belief-planner, belief-planner-chance,
    belief-planner-cvar, oracle), trained policies that come with jaxwalk (co-trained, single-agent, town,
    blind-corner, paper-co-trained, paper-single-agent), run folders or policy files; or your own: my_module:MyDriver,
    file.py:MyDriver, driver.onnx, driver.pt, ppo.zip (docs: drivers)."""
    pedestrians: Annotated[tuple[str, ...], option("always-go", "P [P ...]")] = ("always-go",)
    """Rules (always-go, gap-acceptance, diffusion, distracted, pedsumo, campus); learned, town-learned and
    paper-learned, which come with jaxwalk; run folders or policy files; or a mixture, diffusion:0.7+learned:0.3
    (docs: people)."""
    shield: Annotated[ShieldName | None, option("none", "SHIELD")] = None
    """Put a shield around every driver, which corrects actions that aren't safe by its rule (docs: shields). The
    driver is then called co-trained+rss, and may also be named so."""
    compare: Annotated[tuple[str, ...], option("none", "A B")] = ()
    """Two drivers: say in words if B collides less often than A, and reaches the goal more often (paired tests)."""
    episodes: Annotated[int, option("2000", "N")] = 2000
    """Scenarios in each cell, the same for all."""
    seed: Annotated[int, option("0", "N")] = 0
    """Which set of scenarios; none is ever met in training."""
    scenarios: Annotated[Path | None, option("none", "FILE")] = None
    """Instead of drawing scenarios: those of a file, or of the folder of a `jaxwalk search`, with their street, world
    and people (docs: failure-search)."""
    map: Annotated[tuple[str, ...], option("the run folders', else paper", "MAP [MAP ...]")] = ()
    """Bundled maps, map files, or generated streets: test:20, the first 20 of a split, or test-2000000003, the one of a
    number (docs: streets)."""
    world: Annotated[World | None, option("the run folders', else the map's", "WORLD")] = None
    """What a collision is. paper: the centres closer than 1.5 m; paper-footprint: a body touches the car, which is
    usual on other maps than paper; campus: that too, a slow car, and people at a measured pace
    (docs: real-recordings); town: as paper-footprint, and a car for towns (50 km/h, harder brakes, slower in bends);
    blind-corner and arterial: that too, and people are hidden, and many run (docs: perception).
    Both kinds of contact are always counted."""
    suite: Annotated[Suite | None, option("none", "SUITE")] = None
    """Instead of --map, --world and --people: streets, car and crowd under one name (docs: suites)."""
    people: Annotated[int | None, option("the run folders', else 12", "N")] = None
    """Pedestrians in an episode."""
    jaywalk_multiplier: Annotated[tuple[float, ...] | None, option("the world's", "X [X ...]")] = None
    """P(jaywalk | decision) = jaywalking tendency x this: 1 where people are hidden, else 0.25. Several: an
    evaluation with each."""
    driver_acts: Annotated[Acting, option("mode", "HOW")] = "mode"
    """How a learned driver chooses: mode, the likeliest action; sample, at random as in training."""
    pedestrians_act: Annotated[Acting, option("sample", "HOW")] = "sample"
    """How learned pedestrians choose: mode or sample."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""
    driver_seconds: Annotated[float, option("10", "S")] = 10.0
    """Time limit of a driver that is not JAX for one step of its batch."""
    counterfactuals: Annotated[int, option("0", "N")] = 0
    """Replay up to N collisions of each cell with other actions: who could have avoided them, and would a careful human
    have? About 0.3 s each."""
    out: Annotated[Path | None, option("none", "DIR")] = None
    """Folder for results.json (all metrics), suite.md (the same as tables) and episodes.csv (a row per episode)."""
    encounters: Flag = False
    """Also encounters.parquet, a row per encounter (needs --out, and pip install "jaxwalk[data]")."""
    part: Annotated[str | None, option("all of it", "K/N")] = None
    """Evaluate only the K-th of N parts of the scenarios and keep its rows in --out, for `jaxwalk merge`
    (docs: beyond-one-machine). Needs pip install "jaxwalk[data]"."""
    cluster: Annotated[str | None, option("this process", "WHERE")] = None
    """Play parts as tasks of Ray and put them together: local, on all cores of this machine; auto, on the cluster that
    runs; or its address, ray://HOST:PORT or HOST:PORT. What is finished is kept in --out, and the same command goes on
    (docs: beyond-one-machine). Needs pip install "jaxwalk[cluster]"."""
    parts: Annotated[int | None, option("by the number of episodes", "N")] = None
    """Number of parts for --cluster."""
    json: Flag = False
    """Print one JSON document instead of the table."""
    again: Annotated[Path | None, option("none", "FILE")] = None
    """A results.json: evaluate as it says, and say if the same comes out (exit code 1 if not). Goes with --out, --trust
    and --driver-seconds only."""


@dataclass(frozen=True)
class Merge:
    """Put the parts of an evaluation together: the same files as one evaluation of all.

    For example: jaxwalk merge parts/* --out results
    """

    parts: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="DIR [DIR ...]")] = ()
    """The folders of `jaxwalk evaluate --part 1/N --out DIR` to `--part N/N`, in any order. One that is there twice is
    left out, if its rows are the same."""
    out: Annotated[Path | None, option("needed", "DIR")] = None
    """Folder for results.json, suite.md, episodes.csv and, if the parts were asked for it, encounters.parquet."""
    json: Flag = False
    """Print one JSON document instead of the table."""


@dataclass(frozen=True)
class Play:
    """Show episodes: as a page on which they can be played, a picture or an animation.

    For example: jaxwalk play --driver co-trained route-follower --pedestrians learned --scenario 3 17 --html
    """

    driver: Annotated[tuple[str, ...], option("needed", "D [D ...]")] = ()
    """As in `jaxwalk evaluate`: a rule, a trained policy that comes with jaxwalk, a run folder, a policy file or your
    own driver; several (on a page only) can be watched side by side."""
    shield: Annotated[ShieldName | None, option("none", "SHIELD")] = None
    """Put a shield around every driver, which corrects actions that aren't safe by its rule (docs: shields)."""
    pedestrians: Annotated[str, option("always-go", "P")] = "always-go"
    """always-go, learned, a run folder or a policy file."""
    scenario: Annotated[tuple[int, ...], option("0", "N [N ...]")] = (0,)
    """Number of the scenario: a row of an evaluation with the same seed; several on a page only."""
    seed: Annotated[int, option("0", "N")] = 0
    """Which set of scenarios."""
    scenarios: Annotated[Path | None, option("none", "FILE")] = None
    """Instead of drawing scenarios: those of a file or of a folder of `jaxwalk search` (docs: failure-search)."""
    map: Annotated[tuple[str, ...], option("the run folders', else paper", "MAP [MAP ...]")] = ()
    """Bundled maps, map files, or generated streets: test:20, the first 20 of a split, or test-2000000003, the one of a
    number (docs: streets)."""
    world: Annotated[World | None, option("the run folders', else the map's", "WORLD")] = None
    """What a collision is. paper: the centres closer than 1.5 m; paper-footprint: a body touches the car, which is
    usual on other maps than paper; campus: that too, a slow car, and people at a measured pace
    (docs: real-recordings); town: as paper-footprint, and a car for towns (50 km/h, harder brakes, slower in bends);
    blind-corner and arterial: that too, and people are hidden, and many run (docs: perception).
    Both kinds of contact are always counted."""
    suite: Annotated[Suite | None, option("none", "SUITE")] = None
    """Instead of --map, --world and --people: streets, car and crowd under one name (docs: suites)."""
    people: Annotated[int | None, option("the run folders', else 12", "N")] = None
    """Pedestrians in an episode."""
    jaywalk_multiplier: Annotated[float | None, option("the world's", "X")] = None
    """P(jaywalk | decision) = jaywalking tendency x this: 1 where people are hidden, else 0.25."""
    time: Annotated[float | None, option("the end", "S")] = None
    """The moment that a picture shows [s]."""
    html: Flag = False
    """Make a page; short for --out episode.html."""
    out: Annotated[Path | None, option("episode.png", "FILE")] = None
    """.html for a page, .png, .svg or .pdf for a picture, .gif or .mp4 for an animation; an existing file is
    replaced."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""
    driver_seconds: Annotated[float, option("10", "S")] = 10.0
    """Time limit of a driver that is not JAX for one step of its batch."""


@dataclass(frozen=True)
class Report:
    """One page to read: how drivers fare among people, figures, and the collisions to watch.

    For example: jaxwalk report runs/first co-trained route-follower
    """

    runs: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="[RUN ...]")] = (
        "co-trained", "single-agent", "route-follower",
    )  # fmt: skip
    """Drivers as in `jaxwalk evaluate`: names or run folders, the one that matters most first (default: three that come
    with jaxwalk). Or one folder of `jaxwalk reproduce`: its report is made again."""
    shield: Annotated[ShieldName | None, option("none", "SHIELD")] = None
    """Put a shield around every driver, which corrects actions that aren't safe by its rule (docs: shields)."""
    pedestrians: Annotated[tuple[str, ...], option("always-go learned", "P [P ...]")] = ("always-go", "learned")
    """Up to three populations: always-go, learned, run folders or policy files."""
    episodes: Annotated[int, option("500", "N")] = 500
    """Scenarios for each driver and population."""
    incidents: Annotated[int, option("40", "N")] = 40
    """Show the N worst collisions and N nearest misses of each driver and population; 0: none."""
    counterfactuals: Annotated[int, option("0", "N")] = 0
    """Beside the incidents to watch, which are always replayed: up to N collisions of each driver and population, for
    a table that says which a careful human would have avoided."""
    seed: Annotated[int, option("0", "N")] = 0
    """Which set of scenarios."""
    map: Annotated[tuple[str, ...], option("the run folders', else paper", "MAP [MAP ...]")] = ()
    """Bundled maps, map files, or generated streets: test:20, the first 20 of a split, or test-2000000003, the one of a
    number (docs: streets)."""
    world: Annotated[World | None, option("the run folders', else the map's", "WORLD")] = None
    """What a collision is. paper: the centres closer than 1.5 m; paper-footprint: a body touches the car, which is
    usual on other maps than paper; campus: that too, a slow car, and people at a measured pace
    (docs: real-recordings); town: as paper-footprint, and a car for towns (50 km/h, harder brakes, slower in bends);
    blind-corner and arterial: that too, and people are hidden, and many run (docs: perception).
    Both kinds of contact are always counted."""
    suite: Annotated[Suite | None, option("none", "SUITE")] = None
    """Instead of --map, --world and --people: streets, car and crowd under one name (docs: suites)."""
    people: Annotated[int | None, option("the run folders', else 12", "N")] = None
    """Pedestrians in an episode."""
    jaywalk_multiplier: Annotated[float | None, option("the world's", "X")] = None
    """P(jaywalk | decision) = jaywalking tendency x this: 1 where people are hidden, else 0.25."""
    out: Annotated[Path, option("runs/report", "DIR")] = Path("runs/report")
    """Folder for report.html, figures, tables and numbers; files of an earlier report are replaced."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""
    driver_seconds: Annotated[float, option("10", "S")] = 10.0
    """Time limit of a driver that is not JAX for one step of its batch."""


@dataclass(frozen=True)
class Frontier:
    """Contacts against delay: every driver with its knob turned, and which of them another one beats in both.

    Drivers with a knob (docs: frontier) play with each setting of it, all others bare and behind each shield, on the
    same scenarios of each suite. It says at its start how many episodes there are to play, and after each driver how
    long the rest takes. Run it again to continue after an interruption: what is finished is kept.

    For example: jaxwalk frontier --suite blind-corner --episodes 2000 --out runs/frontier
    """

    out: Annotated[Path, option("runs/frontier", "DIR")] = Path("runs/frontier")
    """Folder for everything; read frontier.md in it."""
    suite: Annotated[tuple[Suite, ...], option("paper town blind-corner", "SUITE [SUITE ...]")] = (
        "paper", "town", "blind-corner",
    )  # fmt: skip
    """Streets, car and crowd under one name (docs: suites); several are played one after the other."""
    driver: Annotated[tuple[str, ...], option("the blind one, all with a knob, the trained ones", "D [D ...]")] = (
        ON_THE_FRONTIER
    )
    """As in `jaxwalk evaluate`: rules, trained policies that come with jaxwalk, run folders or your own drivers."""
    shield: Annotated[tuple[ShieldName, ...], option("all four", "SHIELD [SHIELD ...]")] = SHIELD_NAMES
    """The shields around drivers without a knob (docs: shields)."""
    own_settings: Flag = False
    """Drivers with a knob play with their own setting alone: a table of many drivers on many scenarios, not curves."""
    pedestrians: Annotated[str, option("always-go", "P")] = "always-go"
    """As in `jaxwalk evaluate`."""
    episodes: Annotated[int, option("2000", "N")] = 2000
    """Scenarios for each driver and suite."""
    seed: Annotated[int, option("73", "N")] = 73
    """Seed of the scenarios; nothing was tuned on 73."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""


@dataclass(frozen=True)
class Share:
    """Make one file of a training's policies to share, which knows its results, and a model card beside it.

    For example: jaxwalk share runs/first --out first.safetensors --pedestrians always-go runs/first
    """

    run_folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="DIR")] = field()
    """The run folder of the training."""
    out: Annotated[Path | None, option("needed", "FILE")] = None
    """FILE.safetensors; the card is FILE.md. Existing ones are replaced."""
    pedestrians: Annotated[tuple[str, ...], option("always-go", "P [P ...]")] = ("always-go",)
    """Populations to evaluate the driver among: always-go, learned, run folders or policy files."""
    episodes: Annotated[int, option("2000", "N")] = 2000
    """Scenarios for each population."""
    seed: Annotated[int, option("0", "N")] = 0
    """Which set of scenarios; none is ever met in training."""
    suite: Annotated[Suite | None, option("the training's streets", "SUITE")] = None
    """Where to evaluate it (docs: suites)."""


@dataclass(frozen=True)
class Crashtest:
    """Crash tests: scripted people cross, run and step out before a car at the speeds of protocols. One page.

    For example: jaxwalk crashtest co-trained --suite euro-ncap-style --require 'avoid<=40'
    """

    drivers: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="DRIVER [DRIVER ...]")] = ()
    """As in `jaxwalk evaluate`: a rule, a trained policy that comes with jaxwalk, a run folder, a policy file or your
    own driver."""
    suite: Annotated[str, option("euro-ncap-style", "SUITE")] = "euro-ncap-style"
    """euro-ncap-style, fmvss-127 or r152, or a file of your own tests, FILE.toml or FILE.xosc (docs: crash-tests)."""
    layers: Annotated[tuple[str, ...], option("standard", "LAYER [LAYER ...]")] = ("standard",)
    """Which of the suite's tests: standard, extended, or a layer of robustness, such as faster; all: all of them."""
    beside: Annotated[tuple[str, ...], option("careful-human route-follower", "D [D ...]")] = (
        "careful-human", "route-follower",
    )  # fmt: skip
    """Drivers that stand beside the others for comparison; none: none. Nothing is required of them."""
    require: Annotated[tuple[str, ...], option("none", "WHAT [WHAT ...]")] = ()
    """Exit code 1 where a driver falls short of it: avoid<=40 (no contact up to 40 km/h), impact<=20, keep (no braking
    without need), pass (what the tests ask for); for some tests, CPNCO:avoid<=30."""
    shield: Annotated[ShieldName | None, option("none", "SHIELD")] = None
    """Put a shield around every driver, which corrects actions that aren't safe by its rule (docs: shields)."""
    out: Annotated[Path, option("runs/crashtest", "DIR")] = Path("runs/crashtest")
    """Folder for crashtest.html, crashtest.json and crashtest.csv; files of earlier tests are replaced."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""
    driver_seconds: Annotated[float, option("10", "S")] = 10.0
    """Time limit of a driver that is not JAX for one step of its batch."""
