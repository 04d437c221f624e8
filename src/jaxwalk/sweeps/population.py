"""Population-based training (Jaderberg et al. 2017): which member goes on from whose checkpoint, with which values.

A trial is a member in one generation. Its parent and its values follow from the file, its number and how the generation
before it ended; so any process finds the same ones, and a killed sweep goes on as if nothing had happened. No JAX.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any, ClassVar

from jaxwalk.sweeps.varied import ListedValues, ValueRange, Varied, VariedError

MOST = 1000
"""Most members, and most generations."""
CHANGEABLE = (
    "train.learning_rate", "train.adam_epsilon", "train.max_grad_norm", "train.discount", "train.gae_lambda",
    "train.clip", "train.value_coefficient", "train.reward_scale", "train.minibatches", "train.roles.*.entropy",
    "train.roles.*.epochs", "driver_weights.*", "pedestrian_weights.*",
)  # fmt: skip
"""Fields that may change in the middle of a training: a checkpoint has the same arrays whatever they are, and neither
the world nor the amount of experience depends on them. A star stands for any name."""


class ExtinctError(ValueError):
    """Every training of a generation failed, so that there is none to go on from."""


@dataclass(frozen=True)
class PopulationPlan:
    """The members of a population and how they change."""

    __pydantic_config__: ClassVar = {"extra": "forbid"}

    members: int
    """Number of members."""
    generations: int
    """Number of equal parts of a training; after each but the last, members are compared."""
    truncation: float = 0.25
    """Share of the members that are replaced by copies of the best ones, and share that is copied from."""
    factors: tuple[float, ...] = (0.8, 1.2)
    """A copied value is multiplied by one of these ..."""
    resample: float = 0.25
    """... or, with this probability, drawn anew from all that it may be."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible field, naming it."""
        for name in ("members", "generations"):
            if not 2 <= getattr(self, name) <= MOST:
                raise ValueError(f"{name} must lie in [2, {MOST:,}], not {getattr(self, name)}")
        if not 0 < self.truncation <= 0.5:
            raise ValueError(f"truncation must be above 0 and at most 0.5, not {self.truncation:g}")
        if not self.factors or not all(0 < factor < math.inf and factor != 1 for factor in self.factors):
            raise ValueError(f"factors must be finite numbers above 0 other than 1, not {list(self.factors)}")
        if not 0 <= self.resample <= 1:
            raise ValueError(f"resample must lie in [0, 1], not {self.resample:g}")

    @property
    def count(self) -> int:
        """Return the number of trials."""
        return self.members * self.generations

    @property
    def replaced(self) -> int:
        """Return how many members are replaced after a generation, if none failed."""
        return max(1, math.floor(self.members * self.truncation))

    def generation(self, number: int) -> int:
        """Return the generation of a trial, from 0."""
        return number // self.members

    def member(self, number: int) -> int:
        """Return the member that a trial is, from 0."""
        return number % self.members

    def end(self, number: int, updates: int) -> int:
        """Return the update after which a trial ends, of a training of that many updates."""
        return updates // self.generations * (self.generation(number) + 1)


@dataclass(frozen=True)
class EndedMember:
    """How a member has ended a generation."""

    number: int
    """Number of the trial."""
    labels: Mapping[str, Any]
    """Label of each field's value."""
    value: float | None
    """Its number; None if it failed."""


@dataclass(frozen=True)
class NextMember:
    """What a member begins a generation with."""

    parent: int | None
    """Number of the trial from whose end it goes on; None in the first generation."""
    labels: Mapping[str, Any]
    """Label of each field's value."""


@dataclass(frozen=True)
class Population:
    """A population, its fields and what counts as better."""

    plan: PopulationPlan
    fields: Mapping[str, Varied]
    maximised: bool
    seed: int

    def next_member(self, number: int, before: Sequence[EndedMember]) -> NextMember:
        """Return what a trial begins with.

        A member among the worst, or one that failed, goes on from the end of one of the best, drawn at random, with
        changed values, unless that one's number is the same. All others go on as they are.

        Args:
            number: of the trial.
            before: the generation before it in the order of its members; empty for the first one.

        Raises:
            ExtinctError: all of them failed.
        """
        chance = random.Random(f"{self.seed} {number}")
        if not before:
            return NextMember(None, {name: drawn(varied, chance) for name, varied in self.fields.items()})
        own, count = before[self.plan.member(number)], self.plan.replaced
        best = self.ranked(before)
        if not best:
            generation = self.plan.generation(number) - 1
            raise ExtinctError(f"every training of generation {generation} failed; there is none to go on from")
        failed = [ended for ended in before if ended.value is None]
        if own not in [*best, *failed][-count:] and own.value is not None:
            return NextMember(own.number, own.labels)
        model = chance.choice(best[:count])
        if model.value == own.value:
            return NextMember(own.number, own.labels)
        return NextMember(model.number, {name: self._changed(name, model.labels[name], chance) for name in self.fields})

    def ranked(self, ended: Sequence[EndedMember]) -> list[EndedMember]:
        """Return the members that have a number, the best first; of equal ones the first."""
        sign = -1 if self.maximised else 1
        complete = [each for each in ended if each.value is not None]
        return sorted(complete, key=lambda each: sign * (each.value or 0.0))

    def _changed(self, name: str, label: Any, chance: random.Random) -> Any:
        """Return the label of a copied field: drawn anew, or near the one that is copied."""
        varied = self.fields[name]
        if chance.random() < self.plan.resample:
            return drawn(varied, chance)
        if isinstance(varied, ListedValues):
            return _beside(varied, label, chance)
        moved = [_moved(varied, label, factor) for factor in self.plan.factors]
        inside = [value for value in moved if varied.low <= value <= varied.high]
        return chance.choice(inside) if inside else min(max(chance.choice(moved), varied.low), varied.high)


def drawn(varied: Varied, chance: random.Random) -> Any:
    """Return a label at random: any of a list, or in a range evenly, the logarithm where the file says so."""
    if isinstance(varied, ListedValues):
        return chance.choice(varied.labels)
    share, low, high = chance.random(), float(varied.low), float(varied.high)
    if varied.whole and not varied.log:
        return chance.randint(int(low), int(high))
    found = low * (high / low) ** share if varied.log else low + (high - low) * share
    found = min(max(found, low), high)  # powers round
    return round(found) if varied.whole else found


def _beside(varied: ListedValues, label: Any, chance: random.Random) -> Any:
    """Return the label before or after one in its list."""
    at = varied.labels.index(label)
    return chance.choice([varied.labels[k] for k in (at - 1, at + 1) if 0 <= k < len(varied.labels)])


def _moved(varied: ValueRange, label: int | float, factor: float) -> int | float:
    """Return a value times a factor; a whole number moves by at least 1."""
    found = label * factor
    if not varied.whole:
        return found
    return round(found) if round(found) != label else label + (1 if factor > 1 else -1)


def check_changeable(fields: Mapping[str, Varied]) -> None:
    """Raise VariedError for a field that can't change in the middle of a training."""
    for name in fields:
        if not any(fnmatchcase(name, pattern) for pattern in CHANGEABLE):
            known = ", ".join(pattern.replace("*", "ROLE" if "roles" in pattern else "TERM") for pattern in CHANGEABLE)
            raise VariedError(
                f'{name} can\'t change in the middle of a training, as sampler = "pbt" would; set it in [training], '
                f"or choose another sampler. These can: {known}"
            )
