"""The document of `jaxwalk hidden-intent`: what was requested, and the findings for each jaywalk multiplier."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

from jaxwalk.evaluation.reading import Origin, as_document, as_results
from jaxwalk.evaluation.results import Results
from jaxwalk.metrics.identifiability import Identifiability
from jaxwalk.provenance import Provenance


@dataclass(frozen=True)
class IntentPlan:
    """The size of the experiment, and the recipe of its trainings."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    updates: int
    """Updates in each training."""
    episodes: int
    """Scenarios in each cell."""
    seed: int
    """The first training seed, and the seed of the scenarios."""
    seeds: int
    """How many training seeds there are."""
    recipe: str = "fast"
    """The recipe; older documents don't name it."""
    cars: Sequence[str] = ()
    """The cars that were asked for; none: all."""


@dataclass(frozen=True)
class KnownIntent:
    """How much about people's tendencies could be known."""

    seen: str
    """The case, in words."""
    known: Identifiability | None
    """What could be known; None if there were no people."""

    def as_dict(self) -> dict[str, Any]:
        """Return plain numbers: only ``people``, which is 0, if there were no people."""
        return {"seen": self.seen, **({"people": 0} if self.known is None else asdict(self.known))}


@dataclass(frozen=True)
class IntentStreet:
    """The findings with one jaywalk multiplier."""

    jaywalk_multiplier: float
    results: Results
    identifiability: tuple[KnownIntent, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the multiplier, the results' document and what could be known, as one dict."""
        known = [one.as_dict() for one in self.identifiability]
        return {"jaywalk_multiplier": self.jaywalk_multiplier, **self.results.as_dict(), "identifiability": known}


@dataclass(frozen=True)
class IntentDocument:
    """The whole content of the file."""

    plan: IntentPlan
    provenance: Provenance
    streets: tuple[IntentStreet, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return plain dicts, lists and numbers."""
        streets = [street.as_dict() for street in self.streets]
        return {"plan": asdict(self.plan), "provenance": asdict(self.provenance), "streets": streets}

    def to_json(self) -> str:
        """Return the document as text."""
        return json.dumps(self.as_dict(), indent=2, allow_nan=False) + "\n"


def as_intent_document(content: Any, origin: Origin) -> IntentDocument:
    """Return the content of a JSON file as a typed document. Raise DocumentError if it is damaged."""
    if not isinstance(content, Mapping) or set(content) != {"plan", "provenance", "streets"}:
        raise origin.damaged((), "plan, provenance and streets are not what it has")
    streets = as_document(list[dict[str, Any]], content["streets"], origin.inside("streets"))
    if not streets:
        raise origin.damaged(("streets",), "there are none")
    plan = as_document(IntentPlan, content["plan"], origin.inside("plan"))
    return IntentDocument(
        plan=plan,
        provenance=as_document(Provenance, content["provenance"], origin.inside("provenance")),
        streets=tuple(_street(street, plan, origin.inside("streets", i)) for i, street in enumerate(streets)),
    )


def _street(content: dict[str, Any], plan: IntentPlan, origin: Origin) -> IntentStreet:
    """Return the findings with one multiplier. Raise DocumentError unless each driver has every training seed."""
    own = {"jaywalk_multiplier": float, "identifiability": list[dict[str, Any]]}
    multiplier, known = (as_document(kind, content.get(name), origin.inside(name)) for name, kind in own.items())
    results = as_results({name: value for name, value in content.items() if name not in own}, origin)
    drivers = {cell.driver for cell in results.cells}
    for number, numbers in enumerate(results.over_seeds):
        if numbers.driver not in drivers or len(numbers.training_seeds) != plan.seeds:
            raise origin.damaged(("over_seeds", number), "are not the numbers of a driver over all training seeds")
    found = tuple(_known(one, origin.inside("identifiability", i)) for i, one in enumerate(known))
    return IntentStreet(multiplier, results, found)


def _known(content: dict[str, Any], origin: Origin) -> KnownIntent:
    seen = as_document(str, content.get("seen"), origin.inside("seen"))
    numbers = {name: value for name, value in content.items() if name != "seen"}
    nobody = numbers == {"people": 0}
    return KnownIntent(seen, None if nobody else as_document(Identifiability, numbers, origin))
