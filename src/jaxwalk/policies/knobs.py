"""The knobs of rule-based drivers: one number of each that makes it more careful or more hasty.

A knob is turned over a few settings, from hasty to careful, so that a driver is a line of contacts against delay and
not a point that somebody's choice of a number made. The settings are ours.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from jaxwalk.interfaces import Policy
from jaxwalk.policies.belief_planner import BeliefPlanner
from jaxwalk.policies.careful_human import CarefulHuman
from jaxwalk.policies.cautious_rule import CautiousRule
from jaxwalk.policies.clearance_rule import ClearanceRule
from jaxwalk.policies.crosswalk_yield import CrosswalkYield
from jaxwalk.policies.fuzzy_safety import FuzzySafety
from jaxwalk.policies.idm_yield import IdmYield
from jaxwalk.safety.fuzzy import FuzzyLimits
from jaxwalk.safety.idm import FollowingStyle


@dataclass(frozen=True)
class Knob:
    """One number of a driver, and the settings to try."""

    what: str
    """What the number is, in words."""
    unit: str
    settings: tuple[float, ...]
    """From hasty to careful; the driver's own is among them."""
    usual: float
    """The driver's own setting."""
    turned: Callable[[float], Policy]
    """Makes the driver with a setting."""
    shown: Callable[[float], str] = "{:g}".format
    """Writes a setting."""

    def label(self, driver: str, setting: float) -> str:
        """Return the name of a driver with a setting, such as ``clearance 0.5 m``."""
        return f"{driver} {self.shown(setting)} {self.unit}".rstrip()


KNOBS: dict[str, Knob] = {
    "clearance": Knob(
        "predicted clearance that it keeps", "m", (0.25, 0.5, 1.0, 2.0, 4.0), 1.0,
        lambda x: ClearanceRule(clearance=x),
    ),
    "cautious": Knob(
        "speed beside hidden places", "m/s", (8.0, 5.0, 3.0, 2.0), 3.0, lambda x: CautiousRule(slow=x),
    ),
    "careful-human": Knob(
        "it reacts below this time to collision", "s", (1.0, 2.0, 3.0, 4.0), 2.0,
        lambda x: CarefulHuman(critical=x),
    ),
    "careful-human-aeb": Knob(
        "emergency braking below this time to collision", "s", (1.0, 1.5, 2.0), 1.5,
        lambda x: CarefulHuman(emergency_below=x),
    ),
    "fuzzy-safety": Knob(
        "distance to keep", "m", (1.0, 2.0, 4.0, 8.0), 2.0, lambda x: FuzzySafety(limits=FuzzyLimits(margin=x)),
    ),
    "crosswalk-yield": Knob(
        "emergency braking this long before the last moment", "s", (0.2, 0.4, 0.8, 1.6), 0.4,
        lambda x: CrosswalkYield(spare=x),
    ),
    "idm-yield": Knob(
        "time to the person ahead", "s", (0.5, 1.0, 2.0, 3.0), 1.0, lambda x: IdmYield(style=FollowingStyle(headway=x)),
    ),
    "belief-planner": Knob(
        "cost of a contact, times", "", (0.1, 0.3, 1.0, 3.0, 10.0), 1.0, lambda x: BeliefPlanner(contact_cost=x),
    ),
    "belief-planner-chance": Knob(
        "tolerated probability of a contact", "%", (0.1, 0.03, 0.01, 0.001), 0.01,
        lambda x: BeliefPlanner(tolerated=x), lambda x: f"{100 * x:g}",
    ),
    "belief-planner-cvar": Knob(
        "worst futures that count", "%", (0.8, 0.95, 0.99), 0.95,
        lambda x: BeliefPlanner(tail=x), lambda x: f"{100 * (1 - x):.3g}",
    ),
}  # fmt: skip
"""The knob of each driver that has one, by the driver's name in `DRIVERS`."""
