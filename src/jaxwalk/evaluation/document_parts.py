"""The parts of documents besides cells: intervals, paired comparisons, numbers over training seeds, provenance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol, runtime_checkable

from jaxwalk.metrics import OverSeeds


@runtime_checkable
class Number(Protocol):
    """A number with its 95 % interval; None stands for a value that does not exist or is unknown."""

    @property
    def value(self) -> float | None:
        """The number itself."""
        ...

    @property
    def low(self) -> float | None:
        """The lower end of the interval."""
        ...

    @property
    def high(self) -> float | None:
        """The upper end of the interval."""
        ...


@dataclass(frozen=True)
class Interval:
    """A number with its 95 % interval, and nothing else."""

    value: float | None
    low: float | None
    high: float | None

    @staticmethod
    def of(number: Number) -> Interval:
        """Return the number without its counts."""
        return Interval(number.value, number.low, number.high)


@dataclass(frozen=True)
class ComparedEnding:
    """How often two drivers' episodes end in one way on the same scenarios, with a paired test."""

    a: str
    """Name of the first driver."""
    b: str
    pedestrians: str
    jaywalk_multiplier: float
    ending: str
    """``collision`` or ``goal``."""
    rate_a: float
    rate_b: float
    only_a: int
    """Number of scenarios with this ending for A only."""
    only_b: int
    scenarios: int
    p: float
    """Exact McNemar p-value, two-sided."""
    p_holm: float
    """The p-value adjusted for all tests of the comparison."""
    in_words: str


@dataclass(frozen=True)
class PairedSide:
    """One side of a paired comparison over training seeds."""

    driver: str
    pedestrians: str
    rate: float
    """The share of episodes with the compared ending."""


@dataclass(frozen=True)
class PairedSeeds:
    """How often one ending happens in A and in B; a pair is the same scenario with the same training seed."""

    ending: str
    a: PairedSide
    b: PairedSide
    training_seeds: int
    """Number of training seeds."""
    pairs: int
    both: int
    """Number of pairs with this ending on both sides."""
    only_a: int
    only_b: int
    difference: Interval
    """Rate of B minus rate of A, with the interval over seeds and scenarios."""
    p: float
    """Exact McNemar p-value, two-sided, over all pairs."""


@dataclass(frozen=True)
class SeedNumbers:
    """Numbers over the training seeds of one driver among one population."""

    driver: str
    pedestrians: str
    jaywalk_multiplier: float
    training_seeds: tuple[int | None, ...]
    """The seed of each cell; None where nothing was trained."""
    goal_rate: OverSeeds
    collision_rate: OverSeeds
    timeout_rate: OverSeeds
    collisions_per_km: OverSeeds
    mean_time_to_goal: OverSeeds
    """Mean time to goal [s]."""
    jaywalk_share: OverSeeds
    """Jaywalking's share of the crossings."""


@dataclass(frozen=True)
class Provenance:
    """The origin of results."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    commit: str | None
    """Commit of the source code; None outside a checkout."""
    hardware: str
    versions: dict[str, str]
    """Versions of Python and of the main packages."""
