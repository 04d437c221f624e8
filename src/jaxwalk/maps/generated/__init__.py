"""Generated towns: a street for every number of a family, and splits whose numbers never meet."""

from jaxwalk.maps.generated.named_streets import names_generated
from jaxwalk.maps.generated.refusal import Refusal
from jaxwalk.maps.generated.splits import SPLITS, Split
from jaxwalk.maps.generated.town import ARTERIAL, LAYOUTS, PARKED, TOWN, UNSEEN, Town
from jaxwalk.maps.generated.town_street import TownStreet, make_street

__all__ = [
    "ARTERIAL",
    "LAYOUTS",
    "PARKED",
    "SPLITS",
    "TOWN",
    "UNSEEN",
    "Refusal",
    "Split",
    "Town",
    "TownStreet",
    "make_street",
    "names_generated",
]
