"""Every physical number of the simulator, with its unit. Defaults are the paper's (section III-A)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from jaxwalk.sim.person_kind import FASTEST, PersonKind, check_kinds, in_shares, with_kinds

ContactRule = Literal["disc", "footprint"]
"""What counts as a contact. ``disc``: the centres are closer than ``collision_distance`` (the paper's).
``footprint``: the pedestrian's body overlaps the car's rectangle."""

SMALLEST_STEP = 0.001
"""The shortest step [s]."""
LARGEST = {
    "dt": 1.0, "horizon": 100_000, "substeps": 100, "pedestrians": 1000, "fastest_walk": FASTEST, "wheelbase": 100.0,
    "max_speed": 100.0, "max_acceleration": 100.0, "max_braking": 100.0, "max_lateral": 100.0, "offroad_margin": 100.0,
    "collision_distance": 100.0, "car_length": 100.0,
    "car_width": 100.0, "body_radius": 100.0, "goal_distance": 100.0, "moving_speed": 100.0, "start_clearance": 1000.0,
    "goal_spacing": 1000.0, "kerb_distance": 100.0, "earlier_decisions": 30, "grouped": 1.0, "parked": 1.0,
    "sight": 1000.0, "delay": 10.0, "position_noise": 100.0, "misses": 1.0,
}  # fmt: skip
"""Largest values of the fields. Larger ones make no sense on a street, and their tables could fill the memory."""


@dataclass(frozen=True)
class SimConfig:
    """The rules of a world as plain numbers. An impossible one raises ValueError, which names the field."""

    dt: float = 0.1
    """Duration of a step [s]."""
    horizon: int = 500
    """Steps until an episode times out."""
    substeps: int = 1
    """Parts of a step in which car and people move, while everybody's action is held. With several, an episode ends at
    the moment of a contact, interpolated, instead of at the end of a step."""
    pedestrians: int = 12
    """People in an episode."""
    slowest_walk: float = 1.0
    """Walking speed of the slowest pedestrian [m/s]."""
    fastest_walk: float = 2.0
    """Walking speed of the fastest pedestrian [m/s]."""
    wheelbase: float = 2.5
    """Distance between the car's axles [m]."""
    max_speed: float = 8.33
    """The car's top speed [m/s]."""
    max_steering: float = 0.52
    """Largest steering angle [rad]."""
    max_acceleration: float = 3.0
    """Largest acceleration of the car [m/s2]; the paper doesn't say."""
    max_braking: float = 3.0
    """Largest braking of the car [m/s2]; the paper doesn't say."""
    max_lateral: float = 100.0
    """In the bends of its route the car is no faster than this lateral acceleration allows [m/s2]; the paper has no
    such limit."""
    offroad_margin: float = 0.5
    """A car off the road is put back this far inside it [m]."""
    offroad_speed: float = 0.3
    """Share of its speed that a car put back on the road keeps."""
    collision_distance: float = 1.5
    """Centres of car and pedestrian closer than this collide [m]."""
    contact: ContactRule = "disc"
    """Which rule ends an episode with a collision. Every evaluation measures the contacts by both."""
    car_length: float = 4.5
    """Length of the car's rectangle about its centre [m]."""
    car_width: float = 1.8
    """Width of the car's rectangle [m]."""
    body_radius: float = 0.25
    """Radius of a pedestrian's body [m]."""
    goal_distance: float = 3.0
    """The car has arrived within this distance of its goal [m]."""
    moving_speed: float = 0.5
    """A car at this speed or more is moving when a collision happens [m/s]."""
    start_clearance: float = 10.0
    """No pedestrian starts closer to the car than this [m]."""
    goal_spacing: float = 20.0
    """Each goal of a pedestrian is at least this much walking away from the last [m]."""
    kerb_distance: float = 1.5
    """A pedestrian whose path enters a roadway within this distance is at the kerb [m]."""
    jaywalk_multiplier: float = 0.25
    """P(jaywalk | decision) = jaywalking tendency x this (equation 1)."""
    kinds: tuple[PersonKind, ...] = ()
    """Kinds of people in shares that are 1 together, by the first trait: the first kind has the lowest ones. Empty:
    everybody's jaywalking tendency is that trait, and its pace follows from the second one alone."""
    pace_correlation: float = 0.0
    """How far people's pace tells of their jaywalking tendency: the correlation r of the normal scores of the first two
    traits, in [-1, 1] (a Gaussian copula; Nelsen 2006). Both stay uniform. Their rank correlation (Spearman's, and so
    that of the traits themselves) is 6 / pi asin(r / 2): 0.48 at r = 0.5, and 1 at 1. 0: they are independent."""
    earlier_decisions: int = 0
    """How many decisions of each person about crossings the car saw in encounters before the episode: beliefs start
    from them."""
    grouped: float = 0.0
    """Share of the people who walk in groups of two or three (`jaxwalk.sim.walking_groups`). A population that is named
    then decides by its leaders; one from code does if it is wrapped in `jaxwalk.policies.groups.Groups`."""
    parked: float = 0.0
    """Share of the slots of parking strips in which a vehicle is parked; the paper's street has none."""
    perception: bool = False
    """Whether the driver knows only of people that its car perceives, and people only of a car in their sight; else
    everybody sees everybody, and the next four mean nothing."""
    sight: float = 60.0
    """Range of sight [m]."""
    delay: float = 0.0
    """What is perceived reaches the driver this much later [s], in whole steps."""
    position_noise: float = 0.0
    """Standard deviation of a perceived position, to the east and to the north [m]."""
    misses: float = 0.0
    """Probability that somebody in sight isn't perceived in a step."""

    def __post_init__(self) -> None:
        """Refuse what can't be simulated."""
        positive = (
            "dt", "horizon", "substeps", "pedestrians", "slowest_walk", "wheelbase", "max_speed", "max_acceleration",
            "max_braking", "max_lateral",
            "collision_distance", "car_length", "car_width", "body_radius", "goal_distance", "kerb_distance",
            "goal_spacing", "sight",
        )  # fmt: skip
        for name in positive:
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be above 0, not {getattr(self, name)}")
        if self.contact not in get_args(ContactRule):
            raise ValueError(f"contact must be one of {', '.join(get_args(ContactRule))}, not {self.contact!r}")
        not_negative = (
            "offroad_margin", "moving_speed", "start_clearance", "earlier_decisions", "grouped", "parked", "delay",
            "position_noise", "misses",
        )  # fmt: skip
        for name in not_negative:
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} must be 0 or more, not {getattr(self, name)}")
        for name, most in LARGEST.items():
            if not getattr(self, name) <= most:
                raise ValueError(f"{name} must be at most {most:g}, not {getattr(self, name)}")
        if not self.dt >= SMALLEST_STEP:
            raise ValueError(f"dt must be at least {SMALLEST_STEP:g} s, not {self.dt}")
        if not self.slowest_walk <= self.fastest_walk:
            raise ValueError(f"fastest_walk must be at least slowest_walk ({self.slowest_walk} m/s)")
        check_kinds(self.kinds)
        check_multiplier(self.jaywalk_multiplier)
        if not -1 <= self.pace_correlation <= 1:
            raise ValueError(f"pace_correlation must lie in [-1, 1], not {self.pace_correlation}")
        if not 0 <= self.offroad_speed <= 1:
            raise ValueError(f"offroad_speed must lie in [0, 1], not {self.offroad_speed}")
        if not 0 < self.max_steering < 1.5:
            raise ValueError(f"max_steering must lie in (0, 1.5) rad, not {self.max_steering}")

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Callable[[Any], Any]) -> Any:
        """Return how pydantic reads it: files that were written before there were kinds too."""
        from pydantic_core.core_schema import no_info_before_validator_function

        return no_info_before_validator_function(with_kinds, handler(source))

    @property
    def walking(self) -> tuple[float, float]:
        """Return the lowest and the highest walking speed of people [m/s]."""
        paces = [kind.walk or (self.slowest_walk, self.fastest_walk) for kind in self.kinds]
        slowest, fastest = zip(*paces or [(self.slowest_walk, self.fastest_walk)], strict=True)
        return min(slowest), max(fastest)

    @property
    def fastest(self) -> float:
        """Return the highest speed of people [m/s]."""
        return max([self.walking[1], *(kind.jaywalk[1] for kind in self.kinds if kind.jaywalk)])

    @property
    def tendencies(self) -> dict[float, float]:
        """Return the jaywalking tendencies with their shares of the people; {} where they are uniform in [0, 1]."""
        shares: dict[float, float] = {}
        for kind in self.kinds:
            shares[kind.tendency] = shares.get(kind.tendency, 0.0) + kind.share
        return shares


def check_multiplier(multiplier: float) -> None:
    """Raise ValueError for a jaywalk multiplier that is negative or infinite."""
    if not 0 <= multiplier < float("inf"):
        raise ValueError(f"jaywalk_multiplier must be a finite number of 0 or more, not {multiplier}")


TOWN = SimConfig(contact="footprint", horizon=600, max_speed=13.9, max_braking=7.6, max_lateral=3.0)
HIDING = replace(TOWN, perception=True, parked=0.9, jaywalk_multiplier=1.0)
WORLDS = {
    "paper": SimConfig(),
    "paper-footprint": SimConfig(contact="footprint"),
    "campus": SimConfig(contact="footprint", max_speed=2.7, kinds=in_shares(campus=1.0)),
    "town": TOWN,
    "blind-corner": replace(HIDING, kinds=in_shares(calm=0.3, hurried=0.7)),
    "arterial": replace(HIDING, kinds=in_shares(calm=0.2, hurried=0.4, runner=0.2, child=0.2)),
    "test-track": replace(TOWN, horizon=200, substeps=10, max_speed=20.0, max_lateral=100.0, perception=True),
}
"""Worlds by name.

- ``paper``: the paper's.
- ``paper-footprint``: the same, but a contact of the footprint is a collision.
- ``campus``: that too, and people walk as fast as at a real crosswalk on a campus; the car is no faster than real ones
  that move are there for three quarters of their time (``docs/real-recordings.md``).
- ``town``: as ``paper-footprint``, and the car drives 50 km/h where a lane allows it, slows in bends, and brakes as
  cars do on dry roads. Its longest routes take 26 s without people, so an episode may last 60 s.
- ``blind-corner``: as ``town``, but parked vehicles and buildings hide people, and seven in ten people are in a hurry:
  they jaywalk at nine of ten crossings.
- ``arterial``: as ``blind-corner``, but a fifth of the people are calm, two fifths in a hurry, a fifth runners, and a
  fifth children.
- ``test-track``: the rules of crash tests. Brakes are those of ``town``, scripts limit the car's speed, people are seen
  unless a vehicle hides them, car and people move in parts of 0.01 s, and a test lasts at most 20 s.
"""
OF_WORLD = (
    "contact", "horizon", "substeps", "max_speed", "max_braking", "max_lateral", "parked", "perception",
    "jaywalk_multiplier", "kinds",
)  # fmt: skip
"""What a world decides; everything else is as usual."""


def rules_of(world: str | None, maps: Sequence[str], usual: SimConfig = WORLDS["paper"]) -> SimConfig:
    """Return the usual rules in a named world; without a name, with contacts by footprint on other maps than paper.

    Raise ValueError for a name that doesn't exist.
    """
    if world is None:
        return usual if tuple(maps) == ("paper",) else replace(usual, contact="footprint")
    if world not in WORLDS:
        raise ValueError(f"no world '{world}'; there are: {', '.join(WORLDS)}")
    return replace(usual, **{name: getattr(WORLDS[world], name) for name in OF_WORLD})
