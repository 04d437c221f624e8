"""``jaxwalk bench``."""

from __future__ import annotations

from rich.console import Console

from jaxwalk.bench.benchmark_settings import QUICK, Settings
from jaxwalk.bench.document import as_text, benchmark, write
from jaxwalk.bench.showing import table
from jaxwalk.cli.errors import bad_values
from jaxwalk.cli.options import Bench
from jaxwalk.runs.folder import check_writable

TUNABLE = ("environments", "training_environments", "pedestrians", "seconds", "chunk_rows", "only")
"""Options that replace a field of `Settings` if they are given."""


def run(options: Bench) -> int:
    """Measure and show; nothing is written unless ``--out`` names a folder."""
    settings = make_settings(options)
    if options.out:
        check_writable(options.out)
    document = benchmark(settings)
    if options.out:
        write(options.out, document)
    if options.json:
        print(as_text(document), end="")
    else:
        console = Console()
        console.width = max(console.width, 100)  # the table needs it; a narrower terminal wraps the lines
        console.print(table(document))
    return 0


def make_settings(options: Bench) -> Settings:
    """Return the settings that the options ask for."""
    given = {name: getattr(options, name) for name in TUNABLE if getattr(options, name) not in (None, ())}
    with bad_values():
        return Settings(**{**(QUICK if options.quick else {}), **given, "seed": options.seed})
