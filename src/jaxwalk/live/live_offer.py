"""What the pages of `jaxwalk live` can choose among."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from jaxwalk.live.live_choice import FASTEST, MOST_JAYWALKS, SLOWEST, LiveChoice, LiveError
from jaxwalk.maps.generated import SPLITS
from jaxwalk.policies import SHIPPED
from jaxwalk.policies.policy_names import RULES
from jaxwalk.scenarios import Archived
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.sim.suites import CRASH_WORLD, Where

FAMILIES = {"test": "town", "parked-test": "blind-corner", "arterial": "arterial"}
"""Splits of generated streets that are offered, and the world that suits each."""
STREETS = 4
"""Streets of each split that are offered."""
PLACES = (12, 24, 48, 72)
"""Numbers of people that are offered."""
FROM_FILE = "as in the file"
"""Stands for the world of a file of scenarios."""


@dataclass(frozen=True)
class Offer:
    """What pages can choose among: nothing else is loaded, whatever a page asks for."""

    streets: dict[str, str]
    """Names of streets, and the world that suits each."""
    worlds: tuple[str, ...]
    drivers: tuple[str, ...]
    pedestrians: tuple[str, ...]
    places: tuple[int, ...]
    start: LiveChoice
    """What a page opens first."""
    kept: Archived | None = field(default=None)
    """Scenarios of a file, which decide street, world and places; None: scenarios are drawn."""

    def check(self, choice: LiveChoice) -> None:
        """Raise LiveError for a choice of what isn't offered."""
        offered = {
            "street": self.streets, "world": self.worlds, "driver": self.drivers, "pedestrians": self.pedestrians,
            "places": self.places,
        }  # fmt: skip
        for name, names in offered.items():
            if getattr(choice, name) not in names:
                raise LiveError(f"{name}: {getattr(choice, name)!r:.60} isn't offered; choose one of the list")
        self._check_dial("jaywalk_multiplier", choice.jaywalk_multiplier, (0.0, MOST_JAYWALKS))
        self._check_dial("max_speed", choice.max_speed, (SLOWEST, FASTEST))
        if self.kept is not None and choice.number >= len(self.kept):
            raise LiveError(f"number: the file has scenarios 0 to {len(self.kept) - 1}")

    def _check_dial(self, name: str, value: float | None, limits: tuple[float, float]) -> None:
        """Raise LiveError for a value beyond the limits of a dial, which reach to the value of the file."""
        known = limits if self.kept is None else (*limits, getattr(self.kept.street.config, name))
        if value is not None and not min(known) <= value <= max(known):
            raise LiveError(f"{name}: must be {min(known):g} to {max(known):g}, not {value:g}")


def offer_of(
    drivers: Sequence[str], people: Sequence[str], where: Where, *, seed: int = 0, kept: Archived | None = None
) -> Offer:
    """Return the offer: what is named, which comes first, and what comes with jaxwalk.

    Args:
        drivers: names as `jaxwalk evaluate` takes them.
        people: names of populations.
        where: streets, the world of the first one, and the number of people.
        seed: the seed of the first scenario.
        kept: scenarios of a file, which then decide where.
    """
    cars, crowds = _named("driver", drivers, "co-trained"), _named("pedestrian", people, "learned")
    if kept is None:
        streets = {name: _suiting(name) for name in dict.fromkeys((*where.maps, "paper", *_generated()))}
        worlds = tuple(name for name in WORLDS if name != CRASH_WORLD)
        places = (where.people or PLACES[0], *PLACES)
        first = next(iter(streets))
        start = LiveChoice(first, where.world or streets[first], places[0], cars[0], crowds[0], seed)
    else:
        streets, worlds, places = {kept.street.maps[0].name: FROM_FILE}, (FROM_FILE,), (kept.present.shape[1],)
        start = LiveChoice(next(iter(streets)), FROM_FILE, places[0], cars[0], crowds[0])
    return Offer(
        streets, tuple(dict.fromkeys((start.world, *worlds))), cars, crowds, tuple(sorted({*places})), start, kept
    )


def _named(role: str, named: Sequence[str], usual: str) -> tuple[str, ...]:
    """Return names of policies: those that were named, the usual one, trained ones, then rules."""
    shipped = [name for name in SHIPPED[role] if not name[-1].isdigit()]  # older versions have a number
    return tuple(dict.fromkeys((*named, usual, *shipped, *RULES[role])))


def _generated() -> list[str]:
    return [f"{split}-{number}" for split in FAMILIES for number in SPLITS[split].numbers[:STREETS]]


def _suiting(street: str) -> str:
    """Return the world that suits a street."""
    if street == "paper":
        return "paper"
    return FAMILIES.get(street.rpartition("-")[0], "paper-footprint")
