"""The table of commands. A new command is a line here, a class of options and a module with ``run(options)``."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from functools import reduce
from importlib import import_module
from operator import or_
from typing import Annotated, Any

import tyro

from jaxwalk.cli import options
from jaxwalk.cli.arguments import gathered
from jaxwalk.cli.early import check_names
from jaxwalk.cli.errors import LOST
from jaxwalk.cli.group import group_of, keep_in_touch
from jaxwalk.cli.jax_start import prepare_machine, start_jax, try_jax
from jaxwalk.runs.peer_lost import PeerLostError
from jaxwalk.runs.watchdog import LAUNCHED


@dataclass(frozen=True)
class Command:
    """One command of the command line."""

    name: str
    options: type
    """A dataclass of the options; its docstring is the command's help."""
    module: str
    """Its ``run(options)`` does the work and returns the exit code. It is imported only when the command runs."""
    processes: bool = False
    """Whether only its processes use JAX's devices."""


COMMANDS = (
    Command("train", options.Train, "jaxwalk.cli.train"),
    Command("sweep", options.Sweep, "jaxwalk.cli.sweep"),
    Command("evaluate", options.Evaluate, "jaxwalk.cli.evaluate"),
    Command("merge", options.Merge, "jaxwalk.cli.merge"),
    Command("crashtest", options.Crashtest, "jaxwalk.cli.crashtest"),
    Command("search", options.Search, "jaxwalk.cli.search"),
    Command("play", options.Play, "jaxwalk.cli.play"),
    Command("live", options.Live, "jaxwalk.cli.live"),
    Command("reproduce", options.Reproduce, "jaxwalk.cli.reproduce"),
    Command("report", options.Report, "jaxwalk.cli.report"),
    Command("rate", options.Rate, "jaxwalk.cli.rate"),
    Command("hidden-intent", options.HiddenIntent, "jaxwalk.cli.hidden_intent"),
    Command("co-training", options.CoTraining, "jaxwalk.cli.co_training"),
    Command("generalisation", options.Generalisation, "jaxwalk.cli.generalisation"),
    Command("risk-aware", options.RiskAware, "jaxwalk.cli.risk_aware"),
    Command("frontier", options.Frontier, "jaxwalk.cli.frontier"),
    Command("share", options.Share, "jaxwalk.cli.share"),
    Command("submit", options.Submit, "jaxwalk.cli.submit"),
    Command("tracks", options.Tracks, "jaxwalk.cli.tracks"),
    Command("measure", options.Measure, "jaxwalk.cli.measure"),
    Command("scenario", options.Scenario, "jaxwalk.cli.scenario"),
    Command("import", options.Import, "jaxwalk.cli.importing_streets"),
    Command("streets", options.Streets, "jaxwalk.cli.streets"),
    Command("map new", options.MapNew, "jaxwalk.cli.map_new"),
    Command("map check", options.MapCheck, "jaxwalk.cli.map_check"),
    Command("map draw", options.MapDraw, "jaxwalk.cli.map_draw"),
    Command("export", options.Export, "jaxwalk.cli.export"),
    Command("observations", options.Observations, "jaxwalk.cli.observations"),
    Command("bench", options.Bench, "jaxwalk.cli.bench", processes=True),
)
"""All commands, in the order in which ``jaxwalk --help`` lists them."""


def parse(arguments: list[str]) -> Any:
    """Return the options of the command that the arguments name. Raise SystemExit for ``--help`` and bad options.

    Raises:
        UsageError: an option is given twice that takes one value, or has another name now.
    """
    arguments = _as_one_word(arguments)
    command = next((each for each in COMMANDS if each.name in arguments[:1]), None)
    if command is not None:
        arguments = [command.name, *gathered(command.name, command.options, arguments[1:])]
    kinds: Any = reduce(or_, (Annotated[each.options, tyro.conf.subcommand(each.name)] for each in COMMANDS))
    return tyro.cli(
        kinds,
        args=arguments,
        prog="jaxwalk",
        description="How does a self-driving car behave among people who may jaywalk? Train, evaluate, watch, report. "
        "(docs: NAME) is the page NAME of the documentation: docs/NAME.md in the repository, NAME.html in its site.",
        config=(tyro.conf.OmitArgPrefixes,),
    )


def _as_one_word(arguments: list[str]) -> list[str]:
    """Return the arguments with the two words of a name such as ``map new`` as one."""
    name = " ".join(arguments[:2])
    return [name, *arguments[2:]] if any(each.name == name for each in COMMANDS) else arguments


def run(options: Any) -> int:
    """Run the command that the options belong to, and return its exit code: 3 if another process of it was lost."""
    command = next(each for each in COMMANDS if each.options is type(options))
    keep_in_touch()
    group = group_of(options)
    if group is None or group.process == 0:  # other processes take what process 0 has found good
        check_names(options)
    if getattr(options, "cluster", None) is not None:  # as its workers: another device may round otherwise
        os.environ.setdefault("JAX_PLATFORMS", "cpu")
    set_here = prepare_machine()
    try:
        if command.processes:
            try_jax(set_here)
        else:
            start_jax(set_here, group)
        return import_module(command.module).run(options)
    except PeerLostError as error:
        if LAUNCHED not in os.environ:  # else the launcher knows more about it
            print(f"jaxwalk: {error}", file=sys.stderr)
        return LOST
