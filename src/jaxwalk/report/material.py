"""The material of a report: typed results, and everything else that a page shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any, ClassVar

from jaxwalk.evaluation.document_parts import SeedNumbers
from jaxwalk.evaluation.results import Cell, Results
from jaxwalk.provenance import Provenance
from jaxwalk.report.watched import Gallery

CO_TRAINED, SINGLE_AGENT = "co-trained", "single-agent"
"""The trained drivers."""
ROUTE_FOLLOWER = "route-follower"
"""The driver that ignores people."""
CLEARANCE = "clearance"
"""The strong simple rule that stands beside trained cars."""
ALWAYS_GO, LEARNED, GAP_ACCEPTANCE = "always-go", "learned", "gap-acceptance"
"""The populations."""


class ReportError(ValueError):
    """Raised for results from which no report can be made; one line says what is wrong."""


@dataclass(frozen=True)
class Trainings:
    """What was trained for the results."""

    recipe: str
    seeds: tuple[int, ...]
    """The training seeds."""


@dataclass(frozen=True)
class LearningCurve:
    """One training, update by update; shares are over the episodes that ended in an update."""

    steps: tuple[int | float, ...]
    """Environment steps up to each update."""
    seconds: float
    """The training's duration [s]."""
    episodes: tuple[float, ...]
    """Number of episodes that ended in each update."""
    goal_rate: tuple[float, ...]
    collision_rate: tuple[float, ...]
    timeout_rate: tuple[float, ...]


@dataclass(frozen=True)
class DrawnEpisode:
    """An episode that the page shows as a drawing."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    scenario: int
    seed: int
    """Seed of the scenarios."""
    training_seed: int
    """Training seed of the driver."""
    frame: int = 0
    """The frame to draw."""
    driver: str = CO_TRAINED
    pedestrians: str = LEARNED


@dataclass(frozen=True)
class Material:
    """Everything that a report shows. Raises ReportError if the results lack a cell that a section needs."""

    results: Results
    """Every driver among every population."""
    provenance: Provenance
    minutes: Mapping[str, float]
    """Duration of each part [min]."""
    curves: Mapping[str, Mapping[int, LearningCurve]] = field(default_factory=dict)
    """The trainings, by driver and training seed; for drivers whose training is known."""
    subject: str = CO_TRAINED
    """The driver that sections about one driver show."""
    headline: tuple[str, ...] = (CO_TRAINED, SINGLE_AGENT)
    """The drivers whose numbers come first."""
    trainings: Trainings | None = None
    """What was trained; None if nothing was."""
    ablation: Results | None = None
    """The co-trained driver with several jaywalk multipliers, if that was evaluated; nothing is paired."""
    gallery: Gallery | None = None
    """Episodes and incidents to watch."""
    episode: DrawnEpisode | None = None
    """The drawn episode in which a jaywalker was avoided."""
    episode_svg: str | None = None
    """The drawing of the episode."""
    collision: DrawnEpisode | None = None
    """The drawn collision with a jaywalker; None if there was none."""
    collision_svg: str | None = None

    def __post_init__(self) -> None:
        """Raise ReportError unless everything that a section shows is there."""
        if not self.results.cells:
            raise ReportError("the results have no cells; evaluate again")
        for driver, people in product(self.drivers, self.populations):
            self.cell(driver, people)
            self.over_seeds(driver, people)
        for driver in (self.subject, *self.headline):
            self.cell(driver, self.crowd)
        if self.several:
            for driver, people, seed in product((SINGLE_AGENT, CO_TRAINED), self.populations, self.training_seeds):
                self.cell_of_seed(driver, people, seed)
        if self.ablation is not None:
            for multiplier, people in product(self.multipliers, self.ablated_populations):
                self.ablated(multiplier, people)

    @property
    def drivers(self) -> tuple[str, ...]:
        """The drivers' names in the order of evaluation."""
        return tuple(dict.fromkeys(cell.driver for cell in self.results.cells))

    @property
    def populations(self) -> tuple[str, ...]:
        """The populations' names in the order of evaluation."""
        return tuple(dict.fromkeys(cell.pedestrians for cell in self.results.cells))

    @property
    def crowd(self) -> str:
        """The population of sections about one population: the first except always-go, if there is one."""
        return next((people for people in self.populations if people != ALWAYS_GO), ALWAYS_GO)

    @property
    def beside_paper(self) -> bool:
        """Whether the paper's numbers stand beside ours: everything was on its street, as far as the results say."""
        street = self.results.street
        return street is None or all(found.name == "paper" and found.text is None for found in street.maps)

    @property
    def rival(self) -> str | None:
        """The driver drawn next to the subject: the car trained alone, or else the first other driver."""
        others = [driver for driver in self.drivers if driver != self.subject]
        return SINGLE_AGENT if SINGLE_AGENT in others else next(iter(others), None)

    def met(self, driver: str, pedestrians: str) -> bool:
        """Return whether that driver was evaluated among that population."""
        return any((c.driver, c.pedestrians) == (driver, pedestrians) for c in self.results.cells)

    @property
    def training_seeds(self) -> tuple[int, ...]:
        """All training seeds in order; empty if nothing was trained."""
        return () if self.trainings is None else self.trainings.seeds

    @property
    def several(self) -> bool:
        """Whether there is more than one training seed."""
        return len(self.training_seeds) > 1

    def cell(self, driver: str, pedestrians: str) -> Cell:
        """Return the results of a driver among a population, for the first training seed."""
        return _found(
            (c for c in self.results.cells if (c.driver, c.pedestrians) == (driver, pedestrians)),
            f"{driver} among {pedestrians}",
        )

    def cell_of_seed(self, driver: str, pedestrians: str, seed: int) -> Cell:
        """Return the results of a driver among a population, for one training seed."""
        wanted = (driver, pedestrians, seed)
        return _found(
            (c for c in self.results.cells if (c.driver, c.pedestrians, c.training_seed) == wanted),
            f"{driver} among {pedestrians} of training seed {seed}",
        )

    def over_seeds(self, driver: str, pedestrians: str) -> SeedNumbers:
        """Return the numbers of a driver among a population over all training seeds."""
        return _found(
            (n for n in self.results.over_seeds if (n.driver, n.pedestrians) == (driver, pedestrians)),
            f"numbers over training seeds of {driver} among {pedestrians}",
        )

    def ablated(self, multiplier: float, pedestrians: str) -> SeedNumbers:
        """Return the numbers of the co-trained driver with that jaywalk multiplier."""
        wanted = (multiplier, pedestrians)
        found = self.ablation.over_seeds if self.ablation else ()
        return _found(
            (n for n in found if (n.jaywalk_multiplier, n.pedestrians) == wanted),
            f"the ablation's jaywalk multiplier {multiplier:g} among {pedestrians}",
        )

    @property
    def ablated_populations(self) -> tuple[str, ...]:
        """The names of the ablation's populations in the order of evaluation."""
        cells = self.ablation.cells if self.ablation else ()
        return tuple(dict.fromkeys(cell.pedestrians for cell in cells))

    @property
    def multipliers(self) -> tuple[float, ...]:
        """The jaywalk multipliers of the ablation."""
        cells = self.ablation.cells if self.ablation else ()
        return tuple(dict.fromkeys(cell.jaywalk_multiplier for cell in cells))


def _found(candidates: Any, what: str) -> Any:
    """Return the first candidate. Raise ReportError if there is none."""
    for one in candidates:
        return one
    raise ReportError(f"the results lack {what}; evaluate again")
