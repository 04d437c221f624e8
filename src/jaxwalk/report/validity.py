"""Say what a report's numbers leave out and which thresholds they rest on, mostly by the world's rules."""

from __future__ import annotations

from dataclasses import dataclass

from jaxwalk.metrics import FEWEST_SEEDS, SURE
from jaxwalk.metrics.surrogate import DRAC_CRITICAL, PET_CRITICAL, TTC_CRITICAL
from jaxwalk.report.decision import FEWEST_HITS
from jaxwalk.sim.events import ENCOUNTER_DISTANCE
from jaxwalk.sim.sim_config import SimConfig


@dataclass(frozen=True)
class Said:
    """Something that is said under a name."""

    name: str
    text: str


def limits(sim: SimConfig | None) -> tuple[Said, ...]:
    """Return what the model leaves out. Without the world's rules, what is true of all worlds."""
    found = [
        Said(
            "Shares",
            "Streets are crowded on purpose: a share of simulated scenarios is no crash rate of a real street.",
        ),
        Said(
            "People",
            "They are models, not recordings of people on a street: they walk straight legs at one speed, and decide "
            "at the kerb whether to go.",
        ),
        Said("Traffic", "There is one moving car: no other traffic, no cyclists, no traffic lights."),
        Said("The car", "It is a kinematic bicycle on a dry, level road: it never skids, and its brakes act at once."),
        Said("Senses", _senses(sim)),
        Said("Injuries", "They follow from the impact speed alone; age and size of the person are left out."),
    ]
    return tuple(found)


def _senses(sim: SimConfig | None) -> str:
    if sim is None:
        return "Weather, darkness and sensors are not modelled."
    if not sim.perception:
        return (
            "Everybody is seen at once and without error; nothing hides people, and weather and darkness are left out."
        )
    errors = {
        f"{sim.delay:g} s late": sim.delay,
        f"with an error of {sim.position_noise:g} m": sim.position_noise,
        f"missed in {100 * sim.misses:g} % of steps": sim.misses,
    }
    known = [text for text, size in errors.items() if size] or ["at once and without error"]
    return (
        f"Vehicles and buildings hide people; who is in sight within {sim.sight:g} m is seen {', '.join(known)}. "
        "Weather and darkness are left out."
    )


def thresholds(sim: SimConfig | None) -> tuple[Said, ...]:
    """Return the numbers at which something begins to count."""
    moving = "moving" if sim is None else f"at {sim.moving_speed:g} m/s or more"
    contact = "" if sim is None else f": {_contact(sim)}"
    found = [
        Said("Collision", f"a contact that ends the scenario{contact}"),
        Said("Hit", f"a collision of the car {moving}; in others somebody walks into a car that stands"),
    ]
    if sim is not None:
        limit = f"within {sim.goal_distance:g} m of the goal, {sim.horizon * sim.dt:g} s at most"
        found.append(Said("Arrival", limit))
    found += [
        Said("Encounter", f"a crossing with the car within {ENCOUNTER_DISTANCE:g} m and closing"),
        Said(
            "Near miss",
            f"time to collision below {TTC_CRITICAL:g} s, post-encroachment time below {PET_CRITICAL:g} s, or a "
            f"required deceleration above {DRAC_CRITICAL:g} m/s²",
        ),
        Said("Sure", f"p below {SURE:g}, corrected for all comparisons (Holm); intervals are 95 %"),
        Said(
            "Too few",
            f"fewer than {FEWEST_HITS} hits of two drivers together, where no test could be sure, or than "
            f"{FEWEST_SEEDS} training seeds",
        ),
    ]
    return tuple(found)


def hit_rule(sim: SimConfig | None) -> str:
    """Return by what rule the moving car's contacts are hits; empty if the results don't say."""
    return "" if sim is None else f"{sim.contact}: {_contact(sim)}"


def _contact(sim: SimConfig) -> str:
    """Return what a contact is in a world."""
    if sim.contact == "disc":
        return f"centres closer than {sim.collision_distance:g} m"
    return f"a body ({sim.body_radius:g} m) overlaps the car ({sim.car_length:g} x {sim.car_width:g} m)"
