"""What a report is made of: documents as `jaxwalk reproduce` keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

CO_TRAINED, SINGLE_AGENT = "co-trained", "single-agent"
"""The trained drivers."""
ROUTE_FOLLOWER = "route-follower"
"""The driver that is blind to people."""
ALWAYS_GO, LEARNED = "always-go", "learned"
"""The populations."""
POPULATIONS = (ALWAYS_GO, LEARNED)

Number = Mapping[str, Any]
"""A number with its interval: ``value``, ``low`` and ``high``, each possibly None."""


class ReportError(ValueError):
    """Results that no report can be made of; one line says what is wrong."""


@dataclass(frozen=True)
class Material:
    """Everything that is shown."""

    results: Mapping[str, Any]
    """The document of every driver among every population (`jaxwalk.evaluation.Results.as_dict`)."""
    ablation: Mapping[str, Any]
    """The same of the co-trained driver, with several jaywalk multipliers."""
    curves: Mapping[str, list[dict[str, Any]]]
    """Metrics of each update, by name of the trained driver."""
    provenance: Mapping[str, Any]
    """``commit``, ``hardware`` and ``versions``."""
    plan: Mapping[str, Any]
    """What was asked for: ``recipe``, ``seed``, ``episodes``."""
    minutes: Mapping[str, float]
    """What each part took [min]."""
    episode: Mapping[str, Any] | None = None
    """Which episode is drawn: ``scenario`` and ``seed``."""
    episode_svg: str | None = None
    """Its drawing."""

    @property
    def drivers(self) -> tuple[str, ...]:
        """Names in the order of evaluation."""
        return tuple(dict.fromkeys(cell["driver"] for cell in self.results["cells"]))

    def cell(self, driver: str, pedestrians: str) -> Mapping[str, Any]:
        """The results of a driver among a population."""
        return _find(self.results, driver=driver, pedestrians=pedestrians)

    def ablated(self, multiplier: float, pedestrians: str) -> Mapping[str, Any]:
        """The results of the co-trained driver with that jaywalk multiplier."""
        return _find(self.ablation, jaywalk_multiplier=multiplier, pedestrians=pedestrians)

    @property
    def multipliers(self) -> tuple[float, ...]:
        """Of the ablation."""
        return tuple(dict.fromkeys(cell["jaywalk_multiplier"] for cell in self.ablation["cells"]))


def _find(document: Mapping[str, Any], **wanted: Any) -> Mapping[str, Any]:
    for cell in document["cells"]:
        if all(cell[name] == value for name, value in wanted.items()):
            return cell
    raise ReportError(f"the results lack {' among '.join(str(x) for x in wanted.values())}; evaluate again")
