"""The options of every command. This package does no work and imports little, so that ``--help`` answers at once."""

from jaxwalk.cli.options.for_bench import Bench
from jaxwalk.cli.options.for_drivers import Export, Observations
from jaxwalk.cli.options.for_exchange import Measure, Scenario, Tracks
from jaxwalk.cli.options.for_live import Live
from jaxwalk.cli.options.for_playing import Crashtest, Evaluate, Frontier, Merge, Play, Report, Share
from jaxwalk.cli.options.for_raters import Rate
from jaxwalk.cli.options.for_search import Search
from jaxwalk.cli.options.for_streets import Import, MapCheck, MapDraw, MapNew, Streets
from jaxwalk.cli.options.for_submitting import Submit
from jaxwalk.cli.options.for_sweeps import Sweep
from jaxwalk.cli.options.for_training import CoTraining, Generalisation, HiddenIntent, Reproduce, RiskAware, Train

__all__ = [
    "Bench", "CoTraining", "Crashtest", "Evaluate", "Export", "Frontier", "Generalisation", "HiddenIntent", "Import",
    "Live", "MapCheck", "MapDraw", "MapNew", "Measure", "Merge", "Observations", "Play", "Rate", "Report", "Reproduce",
    "RiskAware", "Scenario", "Search", "Share", "Streets", "Submit", "Sweep", "Tracks",
    "Train",
]  # fmt: skip
