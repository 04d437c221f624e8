"""The parts of documents besides cells: intervals, comparisons, numbers over training seeds, origins."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal, Protocol, runtime_checkable

from jaxwalk.maps import MapText, reference
from jaxwalk.metrics import OverSeeds
from jaxwalk.scenarios import Source
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.wording import counted, first_of


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
    """Rate of B minus rate of A; of several training seeds, with the interval for other seeds and scenarios."""
    p: float | None
    """Two-sided p-value: of one pair of policies the exact McNemar test, of several training seeds the t-test over
    seeds, in the same scenarios. None if there are too few seeds to judge."""


@dataclass(frozen=True)
class PairedDelay:
    """How much later B arrives than A, where both do; a pair is the same scenario with the same training seed."""

    a: str
    """Name of driver A."""
    b: str
    pedestrians: str
    training_seeds: int
    """Number of training seeds."""
    pairs: int
    """Number of pairs in which both arrive."""
    difference: Interval
    """Mean of B's delay minus A's [s], with the interval for other seeds and scenarios."""
    p: float | None
    """Two-sided p-value of the t-test over seeds; None if there are too few to judge."""


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
    moving_contact_rate: OverSeeds
    """Share of the episodes in which the moving car touched somebody, by its footprint."""
    collisions_per_km: OverSeeds
    mean_time_to_goal: OverSeeds
    """Mean time to goal [s]."""
    mean_delay: OverSeeds
    """Mean delay [s]: how much later the car arrives than at full throttle where there is nobody."""
    jaywalk_share: OverSeeds
    """Jaywalking's share of the crossings."""
    waited_share: OverSeeds
    """Share of the approaches with a dangerous moment in which the person waits through the first one."""


@dataclass(frozen=True)
class ScenarioSet:
    """The scenarios that every cell was evaluated on."""

    count: int
    hash: str
    """Hash of the source (`jaxwalk.scenarios.Source`)."""
    seed: int | None = None
    """Seed of drawn scenarios; None for others."""

    @staticmethod
    def of(source: Source) -> ScenarioSet:
        """Return the description of a source's scenarios for results."""
        about = source.describe()
        return ScenarioSet(count=len(source), hash=about["hash"], seed=about.get("seed"))

    @property
    def name(self) -> str:
        """The number of scenarios and their origin, as in ``2,000 scenarios of seed 0``."""
        return counted(self.count, "scenario") + ("" if self.seed is None else f" of seed {self.seed}")

    def as_dict(self) -> dict[str, Any]:
        """Return plain numbers; the seed is left out if there is none."""
        seed = {} if self.seed is None else {"seed": self.seed}
        return {**seed, "count": self.count, "hash": self.hash}


@dataclass(frozen=True)
class StreetOrigin:
    """Where episodes took place."""

    maps: tuple[MapText, ...]
    """The maps, in the order of `Scenario.map`; a map that ships with jaxwalk without its text."""
    sim: SimConfig
    """The rules."""

    @staticmethod
    def of(street: Street) -> StreetOrigin:
        """Return the description of a street."""
        return StreetOrigin(tuple(map(reference, street.maps)), street.config)

    def in_words(self) -> str:
        """Return maps, crowd and contacts, as in ``paper (hash 0123456789abcdef), 12 pedestrians, collisions by disc``.

        Of many maps it names the first ones.
        """
        maps = first_of([f"{found.name} (hash {found.hash})" for found in self.maps], "map")
        return f"{maps}, {counted(self.sim.pedestrians, 'pedestrian')}, collisions by {self.sim.contact}"

    def as_dict(self) -> dict[str, Any]:
        """Return plain dicts; a map that ships with jaxwalk has no text."""
        maps = [{name: x for name, x in asdict(found).items() if x is not None} for found in self.maps]
        return {"maps": maps, "sim": asdict(self.sim)}


Kind = Literal["rule", "shipped policy", "run folder", "policy file", "Python class", "file", "mixture"]
"""Kinds of what names a driver or a population; ``file`` is a network of another framework."""


@dataclass(frozen=True)
class PolicyOrigin:
    """Where a driver or a population comes from."""

    name: str
    """What was named."""
    kind: Kind
    sha256: str | None
    """The first 16 digits of the hash of its file, of a run folder's policy file, or of all files of a mixture.

    None for a rule.
    """

    def in_words(self) -> str:
        """Return kind and hash after the name, as in ``runs/first (run folder, SHA-256 0123456789abcdef)``."""
        return f"{self.name} ({self.kind}" + (")" if self.sha256 is None else f", SHA-256 {self.sha256})")


@dataclass(frozen=True)
class EvaluationOptions:
    """What an evaluation was asked for, besides names, maps and scenarios."""

    jaywalk_multipliers: tuple[float, ...]
    driver_acts: str = "mode"
    """How learned drivers choose: ``mode`` or ``sample``."""
    pedestrians_act: str = "sample"
    """How learned pedestrians choose."""
    compare: tuple[str, str] | None = None
    """Two drivers to compare, if any."""
    counterfactuals: int = 0
    """Most collisions of each cell to replay."""
    encounters: bool = False
    """Whether to write a row per encounter."""
