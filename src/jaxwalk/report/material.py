"""What a report is made of: documents as `jaxwalk reproduce` keeps them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

CO_TRAINED, SINGLE_AGENT = "co-trained", "single-agent"
"""The trained drivers."""
ROUTE_FOLLOWER = "route-follower"
"""The driver that is blind to people."""
ALWAYS_GO, LEARNED = "always-go", "learned"
"""The populations."""

Number = Mapping[str, Any]
"""A number with its interval: ``value``, ``low`` and ``high``, each possibly None."""


class ReportError(ValueError):
    """Results that no report can be made of; one line says what is wrong."""


@dataclass(frozen=True)
class Material:
    """Everything that is shown."""

    results: Mapping[str, Any]
    """Every driver among every population: ``scenarios``, ``cells`` (as `jaxwalk.evaluation.Results` has them, with
    ``training_seed``), ``over_seeds`` and ``paired`` (`jaxwalk.evaluation.training_seeds`)."""
    curves: Mapping[str, Mapping[int, list[dict[str, Any]]]]
    """Metrics of each update, by driver and training seed; of the drivers whose training is known."""
    provenance: Mapping[str, Any]
    """``commit``, ``hardware`` and ``versions``."""
    minutes: Mapping[str, float]
    """What each part took [min]."""
    subject: str = CO_TRAINED
    """The driver that the sections about one driver are about."""
    headline: tuple[str, ...] = (CO_TRAINED, SINGLE_AGENT)
    """The drivers whose numbers come first."""
    plan: Mapping[str, Any] | None = None
    """What was trained: ``recipe``, ``seed``, ``seeds``, ``episodes``; None if nothing was."""
    ablation: Mapping[str, Any] | None = None
    """``results`` of the co-trained driver with several jaywalk multipliers, if there are any; nothing is paired."""
    gallery: Mapping[str, Any] | None = None
    """Episodes and incidents to watch (`jaxwalk.exports.gallery`)."""
    episode: Mapping[str, Any] | None = None
    """Which episode is drawn: ``scenario``, ``seed`` and ``training_seed``."""
    episode_svg: str | None = None
    """Its drawing."""

    @property
    def drivers(self) -> tuple[str, ...]:
        """Names in the order of evaluation."""
        return tuple(dict.fromkeys(cell["driver"] for cell in self.results["cells"]))

    @property
    def populations(self) -> tuple[str, ...]:
        """Names in the order of evaluation."""
        return tuple(dict.fromkeys(cell["pedestrians"] for cell in self.results["cells"]))

    @property
    def crowd(self) -> str:
        """Among whom a section about one population looks: the first that is not always-go, if there is one."""
        return next((people for people in self.populations if people != ALWAYS_GO), ALWAYS_GO)

    @property
    def rival(self) -> str | None:
        """Whom the subject is drawn beside: the car trained alone, else the first other driver."""
        others = [driver for driver in self.drivers if driver != self.subject]
        return SINGLE_AGENT if SINGLE_AGENT in others else next(iter(others), None)

    def met(self, driver: str, pedestrians: str) -> bool:
        """Whether that driver was evaluated among that population."""
        return any((c["driver"], c["pedestrians"]) == (driver, pedestrians) for c in self.results["cells"])

    @property
    def training_seeds(self) -> tuple[int, ...]:
        """All of them, from the first on; none if nothing was trained."""
        if self.plan is None:
            return ()
        return tuple(range(self.plan["seed"], self.plan["seed"] + self.plan["seeds"]))

    @property
    def several(self) -> bool:
        """There is more than one training seed."""
        return len(self.training_seeds) > 1

    def cell(self, driver: str, pedestrians: str, **wanted: Any) -> Mapping[str, Any]:
        """The results of a driver among a population: of the first training seed, unless told otherwise."""
        return _find(self.results["cells"], driver=driver, pedestrians=pedestrians, **wanted)

    def over_seeds(self, driver: str, pedestrians: str) -> Mapping[str, Any]:
        """Numbers of a driver among a population over all training seeds, each with ``mean``, ``iqm`` and ``each``."""
        return _find(self.results["over_seeds"], driver=driver, pedestrians=pedestrians)

    def ablated(self, multiplier: float, pedestrians: str) -> Mapping[str, Any]:
        """The same of the co-trained driver with that jaywalk multiplier."""
        return _find((self.ablation or {})["over_seeds"], jaywalk_multiplier=multiplier, pedestrians=pedestrians)

    @property
    def multipliers(self) -> tuple[float, ...]:
        """Of the ablation."""
        return tuple(dict.fromkeys(cell["jaywalk_multiplier"] for cell in (self.ablation or {"cells": ()})["cells"]))


def _find(cells: Sequence[Mapping[str, Any]], **wanted: Any) -> Mapping[str, Any]:
    for cell in cells:
        if all(cell[name] == value for name, value in wanted.items()):
            return cell
    raise ReportError(f"the results lack {' among '.join(str(x) for x in wanted.values())}; evaluate again")
