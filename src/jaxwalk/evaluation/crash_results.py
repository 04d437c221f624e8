"""The document of crash tests: suite, drivers, and what each driver did in each run. And the same as a table."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict, dataclass, fields

from jaxwalk.evaluation.crash_outcomes import CrashOutcome
from jaxwalk.evaluation.document_parts import PolicyOrigin
from jaxwalk.provenance import Provenance
from jaxwalk.scenarios import Scripted

CRASH_SCHEMA = 1
"""Version of the document."""
NOTICE = (
    "Own scripts in the style of the named protocol: no official test, no score, no rating. A kinematic car on an even "
    "road in daylight says nothing about tyres, night, weather or sensors."
)
"""What every document says of its numbers."""


@dataclass(frozen=True)
class CarUnderTest:
    """The car of the tests, which is that of the world, whatever the driver was trained with."""

    length: float
    """Length [m]."""
    width: float
    max_acceleration: float
    """Largest acceleration [m/s2]."""
    max_braking: float
    """Largest braking [m/s2]."""
    eye: float
    """How far the driver's eye is behind the front [m]."""
    body_radius: float
    """Radius of a person's body [m]."""
    decisions: float
    """Time between two decisions [s]."""
    integration: float
    """Time between two moments at which car and people move [s]."""

    @classmethod
    def of(cls, source: Scripted) -> CarUnderTest:
        """Return the car of a source."""
        rules = source.street.config
        eye = (rules.car_length - rules.wheelbase) / 2
        sizes = (rules.car_length, rules.car_width, rules.max_acceleration, rules.max_braking)
        return cls(*sizes, round(eye, 6), rules.body_radius, rules.dt, round(rules.dt / rules.substeps, 6))


@dataclass(frozen=True)
class DriverUnderTest:
    """A driver, and what it did."""

    name: str
    origin: PolicyOrigin
    beside: bool
    """Whether it only stands beside the others, for comparison."""
    trained_to: float | None
    """The car's top speed in the driver's training [km/h]; None for rules, and where it isn't known."""
    outcomes: tuple[CrashOutcome, ...]


@dataclass(frozen=True)
class CrashResults:
    """Everything that a run of `jaxwalk crashtest` found."""

    suite: str
    title: str
    source: str
    """Where the tests come from."""
    assumed: tuple[str, ...]
    """What is ours, or was not clear in the source."""
    layers: tuple[str, ...]
    hash: str
    """The hash of the scenarios."""
    car: CarUnderTest
    drivers: tuple[DriverUnderTest, ...]
    made: Provenance

    def to_json(self) -> str:
        """Return the document as text; the same results give the same text."""
        document = {"schema": CRASH_SCHEMA, "notice": NOTICE, **asdict(self)}
        return json.dumps(document, indent=2, allow_nan=False) + "\n"

    def to_csv(self) -> str:
        """Return a table with a row for each driver and run; what doesn't exist is empty. Units: `CrashOutcome`."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        columns = [field.name for field in fields(CrashOutcome)]
        writer.writerow(["driver", *columns])
        for driver in self.drivers:
            for outcome in driver.outcomes:
                writer.writerow([driver.name, *(_cell(getattr(outcome, name)) for name in columns)])
        return text.getvalue()


def _cell(value: object) -> object:
    return "" if value is None else f"{value:.3f}" if isinstance(value, float) else value
