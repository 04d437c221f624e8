"""``jaxwalk scenario``."""

from __future__ import annotations

from dataclasses import fields

from jaxwalk.cli.casting import cast
from jaxwalk.cli.checks import check_driver, check_kept, check_number, check_scenario, check_seed
from jaxwalk.cli.errors import DIFFERS, UsageError, bad_values
from jaxwalk.cli.layers import chosen_layers
from jaxwalk.cli.options import Scenario
from jaxwalk.evaluation import named
from jaxwalk.exports.scenario_files import COMMONROAD, EPISODE, MAP, export_scenario, export_tests
from jaxwalk.formats.opendrive import load_library
from jaxwalk.runs.folder import check_writable
from jaxwalk.scenarios import Drawn, Scripted
from jaxwalk.scenarios.archive_file import read_archive
from jaxwalk.scenarios.script_file import read_script
from jaxwalk.wording import counted

OF_TESTS = ("tests", "layers", "out")
"""Options that apply to crash tests."""


def run(options: Scenario) -> int:
    """Play the scenario and write the files; or write those of crash tests."""
    check(options)
    if options.tests is not None:
        return _write_tests(options, options.tests)
    kept = read_archive(options.scenarios) if options.scenarios else None
    check_number(options.scenario, kept)
    street, drivers, people = cast([options.driver], [options.pedestrians], options, kept)
    (driver,), (crowd,) = drivers.values(), people.values()
    where = options.scenarios or f"seed {options.seed}"
    name = f"jaxwalk: {options.driver} among {options.pedestrians}, scenario {options.scenario} of {where}"
    policies, source = {"driver": driver, "pedestrian": crowd}, kept or Drawn(street, options.seed)
    with named({"driver": options.driver, "pedestrian": options.pedestrians}):
        error = export_scenario(street, policies, source, options.scenario, options.out, name=name)
    files = f"{EPISODE} with {MAP}, and {COMMONROAD}"
    print(f"{options.out}: {files}; read back, nobody is off by more than {1000 * error:.4f} mm")
    return 0


def _write_tests(options: Scenario, suite: str) -> int:
    """Write a file for each run of a suite; print which can't be said in OpenSCENARIO."""
    with bad_values():
        found, track = read_script(suite)
        layers = chosen_layers(options.layers, found)
        source = Scripted.of(found, suite, layers=layers, track=track)
        written, refused = export_tests(source, options.out)
    print(*(f"left out: {reason}" for reason in refused), sep="\n", end="\n" if refused else "")
    print(f"{options.out}: {counted(written, 'run')} of {found.name}, with {MAP}")
    return 0 if written else DIFFERS


def check(options: Scenario) -> None:
    """Raise an error for impossible options."""
    if options.tests is None:
        _check_episode(options)
    else:
        _check_tests(options)
    if options.out.exists() and not options.out.is_dir():
        raise UsageError(f"--out {options.out}: is a file; name a folder")
    load_library()
    check_writable(options.out)


def _check_tests(options: Scenario) -> None:
    """Raise UsageError for options that say nothing about crash tests."""
    given = [f"--{name.replace('_', '-')}" for name in _changed(options) if name not in OF_TESTS]
    if given:
        what = "--tests writes crash tests, in which nobody drives, and the suite decides the rest"
        raise UsageError(f"{what}; leave out {', '.join(given)}")


def _changed(options: Scenario) -> list[str]:
    """Return the names of the options that differ from their defaults."""
    return [field.name for field in fields(options) if getattr(options, field.name) != field.default]


def _check_episode(options: Scenario) -> None:
    if "layers" in _changed(options):
        raise UsageError("--layers chooses among crash tests; name a suite with --tests, or leave it out")
    check_driver(options.driver)
    check_scenario(options.scenario)
    check_seed(options.seed)
    if options.scenarios:
        check_kept(options)
