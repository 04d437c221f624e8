"""The document of `jaxwalk risk-aware`: the results, the worst contacts, and whether the limits were kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from jaxwalk.evaluation.harm_numbers import PairedHarm, SeedHarm
from jaxwalk.evaluation.reading import Origin, as_document, as_results
from jaxwalk.evaluation.results import Results


@dataclass(frozen=True)
class LimitKept:
    """A limit at the end of one training."""

    driver: str
    training_seed: int
    cost: str
    limit: float
    reached: float
    """The cost that is limited, on average over the last updates."""
    multiplier: float
    """After the last update."""


@dataclass(frozen=True)
class RiskDocument:
    """The whole content of the file."""

    results: Results
    tails: tuple[SeedHarm, ...]
    compared: tuple[PairedHarm, ...]
    limits: tuple[LimitKept, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return plain dicts, lists and numbers."""
        parts = {name: [asdict(one) for one in getattr(self, name)] for name in PARTS}
        return {"results": self.results.as_dict(), **parts}


PARTS: dict[str, Any] = {
    "tails": tuple[SeedHarm, ...],
    "compared": tuple[PairedHarm, ...],
    "limits": tuple[LimitKept, ...],
}
"""The parts beside the results, and their types."""


def as_risk_document(content: Any, origin: Origin) -> RiskDocument:
    """Return the content of a JSON file as a typed document. Raise DocumentError if it is damaged."""
    if not isinstance(content, Mapping) or set(content) != {"results", *PARTS}:
        raise origin.damaged((), f"results, {', '.join(PARTS)} are not what it has")
    parts = {name: as_document(kind, content[name], origin.inside(name)) for name, kind in PARTS.items()}
    return RiskDocument(as_results(content["results"], origin.inside("results")), **parts)
