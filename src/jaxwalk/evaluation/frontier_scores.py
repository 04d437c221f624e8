"""Contacts against delay: which drivers another driver beats in both, on the same scenarios?

Contacts are those of the moving car, by footprint; delay is over scenarios in which both drivers arrive.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from jaxwalk.metrics import Estimate, Rate, Rows, bootstrap_by_episode, paired_difference, proportion
from jaxwalk.metrics.contacts import touched_while_moving
from jaxwalk.metrics.delay import delays
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.statistics import CONFIDENCE, mean_of

Verdict = Literal["dominated", "not dominated", "cannot be judged", "no real car"]
"""What is said of a driver among its rivals. ``no real car``: it sees what no car can, so that nobody is its rival."""


@dataclass(frozen=True)
class Contender:
    """A driver with a setting of its knob."""

    name: str
    """Its name in tables, such as ``clearance 0.5 m``."""
    family: str
    """The driver's name, whatever the setting: a line of the plot."""
    hidden: bool = False
    """Whether it sees what no real car can."""


@dataclass(frozen=True)
class FrontierScores:
    """How one contender's episodes ended; scenarios are counted from 0."""

    contender: Contender
    touched: tuple[int, ...]
    """Scenarios in which the moving car touches somebody by its footprint."""
    delays: tuple[float | None, ...]
    """The delay in each scenario [s]; None where the car doesn't arrive, or would not without people either."""
    goals: int
    """Scenarios in which the car arrives."""
    timeouts: int
    """Scenarios in which it runs out of time."""

    @property
    def scenarios(self) -> int:
        """The number of scenarios played."""
        return len(self.delays)

    def contacts(self) -> Bool[np.ndarray, "scenario"]:
        """Return in which scenarios the moving car touches somebody."""
        found = np.zeros(self.scenarios, bool)
        found[list(self.touched)] = True
        return found

    def seconds(self) -> Float[np.ndarray, "scenario"]:
        """Return the delay in each scenario [s]; NaN where there is none."""
        return np.array([math.nan if x is None else x for x in self.delays])

    def contact_rate(self) -> Rate:
        """Return the share of scenarios with a contact."""
        return proportion(len(self.touched), self.scenarios)

    def mean_delay(self) -> Estimate:
        """Return the mean delay of the scenarios in which the car arrives [s]."""
        found = self.seconds()
        there = ~np.isnan(found)
        return bootstrap_by_episode(np.nan_to_num(found), there)


@dataclass(frozen=True)
class FrontierSuite:
    """All contenders in one suite, on the same scenarios."""

    suite: str
    pedestrians: str
    """The population's name."""
    scenario_hash: str
    scores: tuple[FrontierScores, ...]

    def __post_init__(self) -> None:
        """Raise ValueError unless all have as many scenarios, and every contact is in one of them."""
        for one in self.scores:
            if one.scenarios != self.scores[0].scenarios:
                raise ValueError(f"{one.contender.name} has another number of scenarios than the first driver")
            if any(not 0 <= number < one.scenarios for number in one.touched):
                raise ValueError(f"{one.contender.name} has a contact in a scenario that nobody played")


@dataclass(frozen=True)
class Rivalry:
    """A rival against a driver on the same scenarios; differences are the rival's number minus the driver's."""

    rival: str
    contacts: Estimate
    """Difference of the shares of scenarios with a contact (Bonett and Price)."""
    delay: Estimate
    """Mean difference of the delays [s], of scenarios in which both arrive (t-interval)."""

    @property
    def beats(self) -> bool:
        """Whether the rival has fewer contacts and less delay, by both intervals."""
        return _below(self.contacts) and _below(self.delay)

    @property
    def yields(self) -> bool:
        """Whether the rival has more contacts or more delay, by an interval: then it doesn't beat the driver."""
        return _above(self.contacts) or _above(self.delay)


@dataclass(frozen=True)
class Standing:
    """What can be said of a driver among its rivals."""

    verdict: Verdict
    beaten_by: tuple[Rivalry, ...] = ()
    """The rivals that beat it, the one with the fewest contacts first."""
    open_against: tuple[str, ...] = ()
    """The rivals of which it is open whether they beat it."""


def scores_of_rows(contender: Contender, rows: Rows) -> FrontierScores:
    """Return a contender's scores from the rows of its evaluation."""
    ended = rows[OUTCOMES]
    return FrontierScores(
        contender=contender,
        touched=tuple(np.flatnonzero(touched_while_moving(rows)).tolist()),
        delays=tuple(None if math.isnan(x) else round(x, 3) for x in delays(rows).tolist()),
        goals=int(ended.goal.sum()),
        timeouts=int((~ended.goal & ~ended.collision).sum()),
    )


def standings(scores: Sequence[FrontierScores]) -> list[Standing]:
    """Return what can be said of each driver, in order.

    A driver is dominated if a rival has fewer contacts and less delay on the same scenarios, by intervals that exclude
    0; it is not dominated if every rival has more contacts or more delay, by an interval; else it can't be judged. The
    intervals of a driver's rivals hold together with 95 % (Bonferroni): some rival of many looks better by chance.
    Drivers that see what no real car can are nobody's rivals.
    """
    each = [(one.contender, one.contacts(), one.seconds()) for one in scores]
    real = [number for number, one in enumerate(scores) if not one.contender.hidden]
    confidence = 1 - (1 - CONFIDENCE) / max(len(real) - 1, 1)

    def standing(number: int) -> Standing:
        if number not in real:
            return Standing("no real car")
        found = [_rivalry(each[number], each[other], confidence) for other in real if other != number]
        beaten_by = sorted((one for one in found if one.beats), key=lambda one: one.contacts.value or 0.0)
        is_open = tuple(one.rival for one in found if not one.beats and not one.yields)
        verdict: Verdict = "dominated" if beaten_by else "cannot be judged" if is_open else "not dominated"
        return Standing(verdict, tuple(beaten_by), is_open)

    return [standing(number) for number in range(len(scores))]


Played = tuple[Contender, Bool[np.ndarray, "scenario"], Float[np.ndarray, "scenario"]]
"""A driver with its contacts and its delays."""


def _rivalry(driver: Played, rival: Played, confidence: float) -> Rivalry:
    """Compare a rival with a driver."""
    (_, contacts, seconds), (who, rivals_contacts, rivals_seconds) = driver, rival
    later = rivals_seconds - seconds
    return Rivalry(
        rival=who.name,
        contacts=paired_difference(contacts, rivals_contacts, confidence=confidence),
        delay=mean_of(later[~np.isnan(later)], confidence=confidence),
    )


def _below(difference: Estimate) -> bool:
    return difference.high is not None and difference.high < 0


def _above(difference: Estimate) -> bool:
    return difference.low is not None and difference.low > 0
