"""``jaxwalk bench``."""

from __future__ import annotations

from rich.console import Console

from jaxwalk.bench.benchmark_settings import HERE, PLANNED, QUICK, Settings
from jaxwalk.bench.document import as_text, benchmark, write
from jaxwalk.bench.gpu_plan import plan_tables, planned, write_plan
from jaxwalk.bench.showing import table
from jaxwalk.cli.errors import UsageError, bad_values
from jaxwalk.cli.options import Bench
from jaxwalk.runs.folder import check_writable

TUNABLE = ("environments", "training_environments", "pedestrians", "seconds", "chunk_rows", "only")
"""Options that replace a field of `Settings` if they are given."""


def run(options: Bench) -> int:
    """Measure and show; nothing is written unless ``--out`` names a folder."""
    settings = make_settings(options)
    if options.out:
        check_writable(options.out)
    document = planned(settings) if settings.plan else benchmark(settings)
    if options.out and settings.plan:
        write_plan(options.out, as_text(document))
    elif options.out:
        write(options.out, document)
    if options.json:
        print(as_text(document), end="")
    else:
        console = Console()
        console.width = max(console.width, 100)  # the table needs it; a narrower terminal wraps the lines
        console.print(plan_tables(document) if settings.plan else table(document))
    return 0


def make_settings(options: Bench) -> Settings:
    """Return the settings that the options ask for. Raises UsageError for options that a plan has no use for."""
    given = {name: getattr(options, name) for name in TUNABLE if getattr(options, name) not in (None, ())}
    usual = QUICK if options.quick else {}
    if options.plan:
        useful = ("environments", "seconds") if options.plan == HERE else ("environments",)
        useless = [f"--{name.replace('_', '-')}" for name in given if name not in useful]
        if useless:
            raise UsageError(f"--plan {options.plan} has no use for {useless[0]}; leave one of them out")
        usual = {"quick": options.quick, "plan": options.plan, **PLANNED[options.plan]}
    with bad_values():
        return Settings(**{**usual, **given, "seed": options.seed})
