"""``jaxwalk evaluate``."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import fields
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from jaxwalk.cli.checks import (
    check_count,
    check_driver,
    check_driver_seconds,
    check_episodes,
    check_kept,
    check_pedestrians,
    check_seed,
)
from jaxwalk.cli.cluster import check_cluster, evaluate_on_cluster
from jaxwalk.cli.errors import DIFFERS, UsageError, bad_values
from jaxwalk.cli.evaluation_asked import work_of
from jaxwalk.cli.evaluation_table import WIDEST, tables
from jaxwalk.cli.options import Evaluate
from jaxwalk.cli.progress import with_progress
from jaxwalk.evaluation import BATCH, Cell, Results, check_parquet
from jaxwalk.evaluation.parts import Part
from jaxwalk.experiments.again import compare_documents, evaluation_again, read_document
from jaxwalk.experiments.evaluating import Evaluation, evaluate_all
from jaxwalk.experiments.in_parts import evaluate_part
from jaxwalk.maps import map_labels
from jaxwalk.report.suite import preventable_said, said, shields_said
from jaxwalk.runs.effort import MOST_EPISODES
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held
from jaxwalk.wording import counted, first_of

GOES_WITH_AGAIN = ("again", "out", "trust", "driver_seconds")
"""The only options that an evaluation takes which is made again."""


def run(options: Evaluate) -> int:
    """Evaluate and show; nothing is written unless ``--out`` names a folder."""
    if options.again is not None:
        return _again(options, options.again)
    check(options)
    with bad_values():
        work = work_of(options)
    if options.part is not None and options.out is not None:
        return _one_part(work, Part.parse(options.part), options.out)
    if options.cluster is not None and options.out is not None:
        show(evaluate_on_cluster(options, work, options.cluster, options.out), as_json=options.json)
        return 0
    with held(options.out) if options.out else nullcontext():
        results = with_progress("evaluating", partial(evaluate_all, work))
    show(results, as_json=options.json)
    return 0


def show(results: Results, *, as_json: bool) -> None:
    """Print results: as a JSON document, or as a table and sentences."""
    if as_json:
        print(results.to_json(), end="")
        return
    console = Console()
    if not console.is_terminal:  # files and pipes have lines of any length
        console.width = max(console.width, WIDEST)
    lines = [*said(results), *shields_said(results), *preventable_said(results), *cost_lines(results.cells)]
    console.print(*tables(results.cells, console), *map(escape, [*lines, scenarios_line(results)]), sep="\n")


def _one_part(work: Evaluation, part: Part, out: Path) -> int:
    """Evaluate a part, and say what it is."""
    with bad_values():
        span = part.span(work.episodes)
    with held(out):
        with_progress("evaluating", partial(evaluate_part, work, part, out))
    which = f"scenarios {span.start:,} to {span.stop - 1:,} of {work.episodes:,}"
    print(f"{out}: part {part.name}, {which}; once all are there: jaxwalk merge DIR [DIR ...] --out RESULTS")
    return 0


def _again(options: Evaluate, path: Path) -> int:
    """Make a document again and say how it differs; return `DIFFERS` if a number differs by more than rounding."""
    _check_again(options, path)
    before = read_document(path)
    with bad_values():
        loading = {"trust": options.trust, "seconds": options.driver_seconds}
        work = evaluation_again(path, before, out=options.out, **loading)
    if options.out and work.options.encounters:
        check_parquet()
    with held(options.out) if options.out else nullcontext():
        found = compare_documents(before, with_progress("evaluating", partial(evaluate_all, work)))
    print(f"{path}: {found.in_words}")
    return DIFFERS if found.differs else 0


def _check_again(options: Evaluate, path: Path) -> None:
    """Raise UsageError for options that a document decides, and for a folder that it is in."""
    given = [f.name for f in fields(Evaluate) if getattr(options, f.name) != f.default]
    extra = [name.replace("_", "-") for name in given if name not in GOES_WITH_AGAIN]
    if extra:
        raise UsageError(f"--{extra[0]}: --again evaluates as {path} says; leave it out, or leave out --again")
    check_driver_seconds(options.driver_seconds)
    if options.out and options.out.resolve() == path.resolve().parent:
        raise UsageError(f"--out {options.out}: would replace {path}, with which it is compared; name another folder")
    if options.out:
        check_writable(options.out)


def check(options: Evaluate) -> None:
    """Raise UsageError for options that make no sense."""
    if options.compare and (len(options.compare) != 2 or len(set(options.compare)) != 2):
        raise UsageError(f"--compare needs two different drivers, not {' '.join(options.compare)}: as in --compare A B")
    check_driver(options.driver or options.compare)
    check_pedestrians(options.pedestrians)
    check_episodes(options.episodes)
    check_seed(options.seed)
    if options.scenarios:
        check_kept(options)
    check_driver_seconds(options.driver_seconds)
    check_count("--counterfactuals", options.counterfactuals, 0, MOST_EPISODES)
    if options.jaywalk_multiplier == ():
        raise UsageError("--jaywalk-multiplier needs a number, such as 0.25")
    if options.cluster is not None:
        check_cluster(options, options.cluster)
    elif options.parts is not None:
        raise UsageError("--parts: goes with --cluster; leave it out, or see --part")
    elif options.part is not None:
        _check_part(options, options.part)
    if options.encounters and not options.out:
        raise UsageError("--encounters needs --out DIR, where encounters.parquet is to be")
    if options.encounters:
        check_parquet()
    if options.out:
        check_writable(options.out)


def _check_part(options: Evaluate, part: str) -> None:
    """Raise UsageError, PartError or MissingLibraryError for a part that can't be evaluated."""
    Part.parse(part).span(options.episodes)
    for name, why in (
        ("json", "results come from jaxwalk merge"),
        ("counterfactuals", "collisions aren't replayed in parts"),
        ("scenarios", "kept scenarios aren't evaluated in parts"),
    ):
        if getattr(options, name):
            raise UsageError(f"--{name}: {why}; leave it out, or leave out --part")
    if options.out is None:
        raise UsageError("--part needs --out DIR, a folder for this part alone")
    check_parquet()


def cost_lines(cells: Sequence[Cell]) -> list[str]:
    """Return for each driver outside JAX a line with the time that a step took in each of its cells."""
    costs: dict[str, list[float]] = {}
    for cell in cells:
        if cell.driver_ms_per_step is not None:
            costs.setdefault(cell.driver, []).append(cell.driver_ms_per_step)
    return [
        f"{driver}: {', '.join(f'{cost:.3g}' for cost in each)} ms for a step of {BATCH} episodes"
        for driver, each in costs.items()
    ]


def scenarios_line(results: Results) -> str:
    """Return a line that names the scenarios played, and where."""
    street = results.street
    where = ""
    if street:
        people = counted(street.sim.pedestrians, "pedestrian")
        where = f", on {first_of(map_labels(street.maps), 'map')}, {people}, collisions by {street.sim.contact}"
    return f"{results.scenarios.name}, hash {results.scenarios.hash}{where}"
