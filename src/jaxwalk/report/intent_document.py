"""The document of `jaxwalk hidden-intent`: the findings in each setting."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from jaxwalk.evaluation.equal_delay import EqualDelay
from jaxwalk.evaluation.harm_numbers import PairedHarm, SeedHarm
from jaxwalk.evaluation.reading import Origin, as_document, as_results
from jaxwalk.evaluation.results import Results
from jaxwalk.metrics.identifiability import Identifiability


def priced(car: str, time_weight: float) -> str:
    """Return the name of a car that was trained with this multiple of the recipe's price of time."""
    return car if time_weight == 1 else f"{car}-time-{time_weight:g}"


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
    """The findings in one setting."""

    setting: str
    """Where it differs from other settings, in words."""
    results: Results
    identifiability: tuple[KnownIntent, ...]
    harms: tuple[SeedHarm, ...]
    """Serious injuries to be expected."""
    paired_harms: tuple[PairedHarm, ...]
    """Those of each car against the blind one's."""
    equal_delays: tuple[EqualDelay, ...]
    """Each car against the blind one at equal delay; none if all were trained with one price of time."""

    def as_dict(self) -> dict[str, Any]:
        """Return the setting, the results' document, what could be known and the harm, as one dict."""
        known = [one.as_dict() for one in self.identifiability]
        harm = {name: [asdict(one) for one in getattr(self, name)] for name in HARM}
        return {"setting": self.setting, **self.results.as_dict(), "identifiability": known, **harm}


HARM: dict[str, Any] = {
    "harms": tuple[SeedHarm, ...],
    "paired_harms": tuple[PairedHarm, ...],
    "equal_delays": tuple[EqualDelay, ...],
}
"""The parts that say how bad contacts are, and their types."""


def as_intent_street(content: Any, seeds: int, origin: Origin) -> IntentStreet:
    """Return the content of a JSON file as the typed findings in one setting.

    Raises:
        DocumentError: it is damaged, or a trained car doesn't have this number of training seeds.
    """
    content = as_document(dict[str, Any], content, origin)
    own = {"setting": str, "identifiability": list[dict[str, Any]], **HARM}
    parts = {name: as_document(kind, content.get(name), origin.inside(name)) for name, kind in own.items()}
    results = as_results({name: value for name, value in content.items() if name not in own}, origin)
    drivers = {cell.driver for cell in results.cells}
    for number, numbers in enumerate(results.over_seeds):
        trained = numbers.training_seeds != (None,)
        if numbers.driver not in drivers or (trained and len(numbers.training_seeds) != seeds):
            raise origin.damaged(("over_seeds", number), "are not the numbers of a driver over all training seeds")
    if {found.driver for found in parts["harms"]} != drivers or results.made is None:
        raise origin.damaged(("harms",), "a driver has no number of injuries, or it is not said what computed them")
    known = parts.pop("identifiability")
    found = tuple(_known(one, origin.inside("identifiability", i)) for i, one in enumerate(known))
    return IntentStreet(results=results, identifiability=found, **parts)


def _known(content: dict[str, Any], origin: Origin) -> KnownIntent:
    seen = as_document(str, content.get("seen"), origin.inside("seen"))
    numbers = {name: value for name, value in content.items() if name != "seen"}
    nobody = numbers == {"people": 0}
    return KnownIntent(seen, None if nobody else as_document(Identifiability, numbers, origin))
