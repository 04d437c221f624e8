"""Decide from comparisons on the same scenarios which driver is safer: pure functions of plain numbers.

Everything is judged by *hits*: scenarios that end with a collision of the moving car.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from jaxwalk.evaluation.document_parts import Number, PairedSeeds
from jaxwalk.metrics import SURE, holm

FEWEST_HITS = 10
"""Two drivers who hit fewer people together, and too few for any test, cannot be told apart or called alike."""

Training = Literal["none", "unknown", "one", "few", "enough"]
"""What stands behind the drivers: rules alone; rules and Python classes, which may have been trained or not; one
training each; several, but too few to judge training; enough."""
Kind = Literal["alone", "uncompared", "unjudged", "safest", "ahead", "even", "depends"]
"""Kinds of decision.

``alone``: there is one driver. ``uncompared``: nothing was compared. ``unjudged``: no comparison can be judged.
``safest``: one driver is safer than each other. ``ahead``: it is safer than some, and not told apart from the rest.
``even``: no difference is shown. ``depends``: one is safer among some people, the other among others.
"""


@dataclass(frozen=True)
class Evidence:
    """What is known of the drivers' safety."""

    drivers: tuple[str, ...]
    populations: tuple[str, ...]
    hits: Mapping[tuple[str, str], Number]
    """Share of scenarios with a hit, by driver and population."""
    goals: Mapping[tuple[str, str], Number]
    """Share of scenarios in which the car arrives."""
    compared: tuple[PairedSeeds, ...]
    """Hits of every two drivers among each population."""
    training: Training
    seeds: int
    """Number of training seeds; 0 for rules."""
    timeouts: Mapping[tuple[str, str], Number] = field(default_factory=dict)
    """Share of scenarios in which the car runs out of time; empty if unknown."""
    delays: Mapping[tuple[str, str], Number] = field(default_factory=dict)
    """Mean delay of the car where it arrives [s]; empty if unknown."""

    def mean(self, of: Mapping[tuple[str, str], Number], driver: str) -> float | None:
        """Return the mean of a driver's shares over the populations; None if one is unknown."""
        values = [of[driver, people].value for people in self.populations]
        known = [value for value in values if value is not None]
        return sum(known) / len(known) if known and len(known) == len(values) else None


@dataclass(frozen=True)
class Duel:
    """Two drivers among one population."""

    found: PairedSeeds
    p: float | None
    """The p-value adjusted for all comparisons; None if there are too few training seeds."""
    tests: int
    """Number of comparisons with a p-value."""

    @property
    def people(self) -> str:
        """The population."""
        return self.found.a.pedestrians

    @property
    def drivers(self) -> frozenset[str]:
        """Both drivers."""
        return frozenset((self.found.a.driver, self.found.b.driver))

    @property
    def hits(self) -> int:
        """The hits of both drivers together."""
        return 2 * self.found.both + self.found.only_a + self.found.only_b

    @property
    def judged(self) -> bool:
        """Whether there are seeds and hits enough to judge.

        Of n scenarios that only one driver survives, the exact test's smallest p-value is 2 / 2^n.
        """
        differing = self.found.only_a + self.found.only_b
        possible = 2 * 0.5**differing * self.tests < SURE
        return self.p is not None and (possible or self.hits >= FEWEST_HITS)

    @property
    def safer(self) -> str | None:
        """The safer driver, if that is sure."""
        a, b = self.found.a, self.found.b
        if self.p is None or self.p >= SURE or not self.judged or a.rate == b.rate:
            return None
        return a.driver if a.rate < b.rate else b.driver


@dataclass(frozen=True)
class Decision:
    """Who is safer, as far as the evidence tells."""

    kind: Kind
    order: tuple[str, ...]
    """The drivers, those with the fewest hits first (mean over populations)."""
    leader: str
    """The driver that all others are compared with (`decide`)."""
    beaten: tuple[str, ...]
    """The drivers that are less safe than the leader, in order."""
    tied: tuple[str, ...]
    """The others, in order: no difference from the leader is shown, or it cannot be judged."""
    duels: tuple[Duel, ...]

    def between(self, a: str, b: str) -> list[Duel]:
        """Return the comparisons of two drivers, one for each population."""
        return [duel for duel in self.duels if duel.drivers == {a, b}]

    def standing(self, driver: str) -> str:
        """Return in a word or two how a driver stands to the leader."""
        if driver == self.leader:
            return LEADER.get(self.kind, "fewest hits")
        if driver in self.beaten:
            return "less safe"
        judged = any(duel.judged for duel in self.between(self.leader, driver))
        return "no difference shown" if judged else "cannot be judged"


LEADER: dict[Kind, str] = {"safest": "safest", "ahead": "among the safest", "alone": "compared with nobody"}
"""What is said of the leader; where nothing is sure, that it has the fewest hits."""


def decide(evidence: Evidence) -> Decision:
    """Return who is safer.

    One driver is safer than another if that is sure among some population, and the opposite among none. The leader is,
    of the drivers than which none is safer, the one that is safer than the most others; of several, the one with the
    fewest hits.
    """
    order = tuple(sorted(evidence.drivers, key=lambda driver: _hits(evidence, driver)))
    duels = judge(evidence.compared)
    free = [driver for driver in order if not any(_safer(duels, other, driver) for other in order)]
    beats = {driver: [other for other in order if _safer(duels, driver, other)] for driver in free or order}
    leader = max(beats, key=lambda driver: len(beats[driver]))  # of several the first, who has the fewest hits
    others = [driver for driver in order if driver != leader]
    beaten = tuple(beats[leader])
    tied = tuple(driver for driver in others if driver not in beaten)
    return Decision(_kind(order, duels, beaten, tied), order, leader, beaten, tied, duels)


def judge(compared: Sequence[PairedSeeds]) -> tuple[Duel, ...]:
    """Return the comparisons with their adjusted p-values."""
    tested = [found.p for found in compared if found.p is not None]
    adjusted = iter(holm(tested))
    return tuple(Duel(found, None if found.p is None else next(adjusted), len(tested)) for found in compared)


def _hits(evidence: Evidence, driver: str) -> float:
    found = evidence.mean(evidence.hits, driver)
    return float("inf") if found is None else found


def _safer(duels: Sequence[Duel], a: str, b: str) -> bool:
    """Return whether driver A is safer than B."""
    found = {duel.safer for duel in duels if duel.drivers == {a, b}}
    return a in found and b not in found


def _kind(order: Sequence[str], duels: Sequence[Duel], beaten: Sequence[str], tied: Sequence[str]) -> Kind:
    if len(order) == 1:
        return "alone"
    if not duels:
        return "uncompared"
    if beaten:
        return "ahead" if tied else "safest"
    if any(duel.safer for duel in duels):  # but some population says otherwise
        return "depends"
    return "even" if any(duel.judged for duel in duels) else "unjudged"
