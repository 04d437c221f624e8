"""Generated towns: a street for every number of a family, and splits whose numbers never meet.

A name is imported when it is first used: what only lists splits needs no geometry.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from jaxwalk.lazy import imported_when_used

if TYPE_CHECKING:
    from jaxwalk.maps.generated.named_streets import names_generated as names_generated
    from jaxwalk.maps.generated.refusal import Refusal as Refusal
    from jaxwalk.maps.generated.splits import SPLITS as SPLITS
    from jaxwalk.maps.generated.splits import Split as Split
    from jaxwalk.maps.generated.town import ARTERIAL as ARTERIAL
    from jaxwalk.maps.generated.town import LAYOUTS as LAYOUTS
    from jaxwalk.maps.generated.town import PARKED as PARKED
    from jaxwalk.maps.generated.town import TOWN as TOWN
    from jaxwalk.maps.generated.town import UNSEEN as UNSEEN
    from jaxwalk.maps.generated.town import Town as Town
    from jaxwalk.maps.generated.town_street import TownStreet as TownStreet
    from jaxwalk.maps.generated.town_street import make_street as make_street

_HOMES = {
    "ARTERIAL": "town",
    "LAYOUTS": "town",
    "PARKED": "town",
    "SPLITS": "splits",
    "TOWN": "town",
    "UNSEEN": "town",
    "Refusal": "refusal",
    "Split": "splits",
    "Town": "town",
    "TownStreet": "town_street",
    "make_street": "town_street",
    "names_generated": "named_streets",
}
"""Each public name, and the module of this package that defines it."""

__all__ = [*_HOMES]  # pyright: ignore[reportUnsupportedDunderAll]

__getattr__, __dir__ = imported_when_used(__name__, _HOMES)
