"""``jaxwalk crashtest``."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from rich.box import SIMPLE
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from jaxwalk.cli.checks import check_driver_seconds
from jaxwalk.cli.errors import DIFFERS, UsageError, bad_values
from jaxwalk.cli.layers import chosen_layers
from jaxwalk.cli.options import Crashtest
from jaxwalk.evaluation.crash_requirements import CrashRequirement
from jaxwalk.evaluation.crash_results import CrashResults, DriverUnderTest
from jaxwalk.experiments.crash_testing import CrashTests, run_crash_tests
from jaxwalk.policies.shield_names import with_shield
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held
from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.script_file import read_script
from jaxwalk.wording import counted

NONE = "none"
"""The word for no driver beside the others."""
SHOWN = 8
"""Shortfalls that are shown of each driver."""
WIDTH = 120
"""What the table needs [characters]."""
SHORT = {"avoided": "-", "not met": "not met", "kept": "keeps", "braked": "brakes"}
"""What the table shows where there is no impact."""


def run(options: Crashtest) -> int:
    """Test the drivers and write the page; return `DIFFERS` if one falls short of what is required."""
    required = check(options)
    with bad_values():
        work = _work(options)
    for requirement in required:
        requirement.check(work.source.cases)
    console = Console(stderr=True)
    with held(options.out):
        results = run_crash_tests(work, lambda name: console.print(f"testing {name}", markup=False))
    shown = Console()
    shown.width = max(shown.width, WIDTH)  # a narrower terminal wraps the lines
    for driver in results.drivers:
        if not driver.beside:
            shown.print(
                f"{driver.name}: impact speed [km/h]; -: no contact; ~: left its lane",
                table(driver),
                sep="\n",
                markup=False,
            )
    lines = list(shortfalls(results, required))
    shown.print(*map(escape, lines), f"Open {options.out / 'crashtest.html'}", sep="\n", soft_wrap=True)
    return DIFFERS if lines else 0


def _work(options: Crashtest) -> CrashTests:
    suite, track = read_script(options.suite)
    layers = chosen_layers(options.layers, suite)
    source = Scripted.of(suite, options.suite, layers=layers, track=track)
    named = with_shield(options.drivers, options.shield)
    beside = tuple(name for name in dict.fromkeys(options.beside) if name not in (*named, NONE))
    loading = {"trust": options.trust, "seconds": options.driver_seconds}
    drivers = {name: contestant(source.street, "driver", name, **loading) for name in (*named, *beside)}
    return CrashTests(source, drivers, beside, layers, options.out)


def table(driver: DriverUnderTest) -> Table:
    """Return a driver's impact speeds, by test and speed."""
    speeds = sorted({outcome.speed for outcome in driver.outcomes})
    rows: dict[str, dict[float, str]] = {}
    for outcome in driver.outcomes:
        name = outcome.test if outcome.variant is None else f"{outcome.test}, {outcome.variant}"
        text = SHORT.get(outcome.result, "") if outcome.impact is None else f"{outcome.impact:.0f}"
        text += " ~" if outcome.swerves else ""
        rows.setdefault(name, {})[outcome.speed] = text
    found = Table(box=SIMPLE)
    for heading in ("test", *(f"{speed:g}" for speed in speeds)):
        found.add_column(heading, justify="left" if heading == "test" else "right")
    for name, cells in rows.items():
        found.add_row(escape(name), *(cells.get(speed, "") for speed in speeds))
    return found


def shortfalls(results: CrashResults, required: list[CrashRequirement]) -> Iterator[str]:
    """Yield a line for each driver and requirement that it falls short of."""
    tested = [driver for driver in results.drivers if not driver.beside]
    for driver, requirement in product(tested, required):
        missed = requirement.shortfalls(driver.outcomes)
        if missed:
            tail = f" and {len(missed) - SHOWN} more" if len(missed) > SHOWN else ""
            runs = counted(len(missed), "run")
            yield f"{driver.name} falls short of {requirement.text} in {runs}: {'; '.join(missed[:SHOWN])}{tail}"


def check(options: Crashtest) -> list[CrashRequirement]:
    """Raise an error for impossible options; return what is required."""
    if not options.drivers:
        raise UsageError("no driver: name one such as co-trained or careful-human, a run folder or a policy file")
    check_driver_seconds(options.driver_seconds)
    check_writable(options.out)
    return [CrashRequirement.of(text) for text in options.require]
