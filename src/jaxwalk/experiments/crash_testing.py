"""`jaxwalk crashtest`: play the tests of a suite with every driver, and write what they did.

crashtest.html     a matrix for each driver, and a replay behind each cell
crashtest.json     all numbers (`jaxwalk.evaluation.crash_results`)
crashtest.csv      a row for each driver and run
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jaxwalk.evaluation import named
from jaxwalk.evaluation.crash_outcomes import CrashOutcome, crash_outcomes, play_tests
from jaxwalk.evaluation.crash_results import CarUnderTest, CrashResults, DriverUnderTest
from jaxwalk.exports.replays import entries_played, page_document
from jaxwalk.interfaces import Policy
from jaxwalk.policies import AlwaysGo
from jaxwalk.provenance import provenance
from jaxwalk.report.crash_page import write_crash_page
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.runs.trained_speed import trained_speed
from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.staging import KMH
from jaxwalk.writing import together, write_whole

PEOPLE = "always-go"
"""The population of crash tests: people do as their script says."""


@dataclass(frozen=True)
class CrashTests:
    """What to test."""

    source: Scripted
    drivers: Mapping[str, Policy]
    beside: tuple[str, ...]
    """Which of the drivers only stand beside the others."""
    layers: tuple[str, ...]
    out: Path
    """Folder to write into; files of earlier tests are replaced."""


def run_crash_tests(work: CrashTests, tell: Callable[[str], None]) -> CrashResults:
    """Test all drivers, write the three files, and return the results. ``tell`` is called with each driver's name."""
    suite, street = work.source.suite, work.source.street
    drivers, entries = [], []
    for name, policy in work.drivers.items():
        tell(name)
        outcomes, episodes = _tested(work.source, name, policy)
        drivers.append(
            DriverUnderTest(name, policy_origin("driver", name), name in work.beside, _trained_to(name), outcomes)
        )
        entries += episodes
    results = CrashResults(
        suite=suite.name, title=suite.title, source=suite.source, assumed=suite.assumed, layers=work.layers,
        hash=work.source.hash(), car=CarUnderTest.of(work.source), drivers=tuple(drivers), made=provenance(),
    )  # fmt: skip
    work.out.mkdir(parents=True, exist_ok=True)
    with together():
        write_crash_page(work.out / "crashtest.html", results, page_document(street, entries))
        write_whole(work.out / "crashtest.json", results.to_json())
        write_whole(work.out / "crashtest.csv", results.to_csv())
    return results


def _tested(source: Scripted, name: str, policy: Policy) -> tuple[tuple[CrashOutcome, ...], list[dict[str, Any]]]:
    """Return what a driver did in all runs, and the page's entries of them."""
    outcomes, entries = [], []
    with named({"driver": name, "pedestrian": PEOPLE}):
        for part in play_tests({"driver": policy, "pedestrian": AlwaysGo()}, source):
            outcomes += crash_outcomes(source, part)
            entries += entries_played(source.street, source, part, (name, PEOPLE))
    return tuple(outcomes), entries


def _trained_to(name: str) -> float | None:
    """Return the car's top speed in a driver's training [km/h], if it had one and it is known."""
    speed = trained_speed(name)
    return None if speed is None else round(KMH * speed, 1)
