"""The commands and their options. No heavy imports: ``--help`` must answer at once."""

from typing import Annotated

import tyro

from jaxwalk.cli.options.exchange import Measure, Scenario, Tracks
from jaxwalk.cli.options.formats import Export, Observations
from jaxwalk.cli.options.judging import Evaluate, Play, Report, Share
from jaxwalk.cli.options.option import UsageError
from jaxwalk.cli.options.speed import Bench
from jaxwalk.cli.options.training import HiddenIntent, Reproduce, Train

__all__ = [
    "Bench", "Command", "Evaluate", "Export", "HiddenIntent", "Measure", "Observations", "Play", "Report", "Reproduce",
    "Scenario", "Share", "Tracks", "Train", "UsageError",
]  # fmt: skip

Command = (
    Annotated[Train, tyro.conf.subcommand("train")]
    | Annotated[Evaluate, tyro.conf.subcommand("evaluate")]
    | Annotated[Play, tyro.conf.subcommand("play")]
    | Annotated[Reproduce, tyro.conf.subcommand("reproduce")]
    | Annotated[Report, tyro.conf.subcommand("report")]
    | Annotated[HiddenIntent, tyro.conf.subcommand("hidden-intent")]
    | Annotated[Share, tyro.conf.subcommand("share")]
    | Annotated[Tracks, tyro.conf.subcommand("tracks")]
    | Annotated[Measure, tyro.conf.subcommand("measure")]
    | Annotated[Scenario, tyro.conf.subcommand("scenario")]
    | Annotated[Export, tyro.conf.subcommand("export")]
    | Annotated[Observations, tyro.conf.subcommand("observations")]
    | Annotated[Bench, tyro.conf.subcommand("bench")]
)
"""What the command line can ask for."""
