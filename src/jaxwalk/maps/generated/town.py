"""The family of generated towns: every parameter with its range. ``docs/streets.md`` says why the ranges are these."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, fields
from functools import cached_property

LAYOUTS = ("straight", "tee", "cross", "skewed", "staggered", "block")
"""A street without junction; one junction with one arm, two arms, or two arms in one skewed line; two junctions with an
arm each, on opposite sides; two junctions with two arms and one."""
Range = tuple[float, float]
"""Smallest and largest value; each between is equally likely."""

MOST_LANES = 3
"""Most lanes in one direction."""
FASTEST = 13.9
"""Highest speed limit [m/s]: 50 km/h."""
SHARPEST_ARM = 30.0
"""Smallest angle between an arm and the main street [degrees]."""


@dataclass(frozen=True)
class Town:
    """A family of streets. Raises ValueError, which names the field, if a value makes no street.

    Each street draws a value from every range; what differs between its roads is drawn for each road.
    """

    layouts: tuple[str, ...] = LAYOUTS
    """Which layouts there are, each equally likely."""
    main_length: Range = (130.0, 170.0)
    """Length of the main street [m]."""
    arm_length: Range = (50.0, 75.0)
    """Length of a side street, from the middle of the main street [m]; longer where its corners need it."""
    block_length: Range = (55.0, 75.0)
    """Distance between two junctions [m]; longer where their corners need it."""
    angle: Range = (78.0, 102.0)
    """Angle between the main street and an arm [degrees]."""
    skewed_angle: Range = (58.0, 70.0)
    """The same in the layout ``skewed``."""
    curvature: Range = (0.0, 1 / 60)
    """Curvature of a bend, to the left or to the right [1/m]."""
    lanes: tuple[int, ...] = (1, 1, 2)
    """Lanes of each direction of the main street, each entry equally likely."""
    arm_lanes: tuple[int, ...] = (1, 1, 1, 2)
    """Lanes of each direction of a side street."""
    lane_width: Range = (3.0, 3.5)
    """Width of a lane [m]."""
    one_way: float = 0.15
    """Probability that a road is one-way."""
    median: float = 0.35
    """Probability that a two-way road has a painted median, in which its islands lie."""
    median_width: Range = (2.2, 3.0)
    """Width of a median [m]."""
    parking: float = 0.4
    """Probability of a parking strip, for each side of a road."""
    parking_width: Range = (2.0, 2.3)
    """Width of a parking strip [m]."""
    kerb_radius: Range = (5.0, 9.0)
    """Radius of the kerb at a corner [m]."""
    sidewalk_width: Range = (2.2, 4.0)
    """Width of all sidewalks [m]."""
    crosswalks: Range = (0.5, 1.0)
    """Probability of a crosswalk at each arm of a junction; those without which somebody couldn't reach everybody are
    always there."""
    middle_crosswalks: Range = (0.3, 1.0)
    """Crosswalks away from junctions for each 100 m of road."""
    crosswalk_width: Range = (3.0, 5.0)
    """Width of a crosswalk, along the road [m]."""
    unmarked: float = 0.2
    """Probability that a crossing has no markings."""
    raised: float = 0.15
    """Probability that a crosswalk with markings is raised: cars pass it slowly."""
    island: float = 0.7
    """Probability that a crosswalk over a median has an island."""
    zone_length: Range = (12.0, 24.0)
    """Length of a jaywalk zone, if there is room [m]."""
    building: float = 0.75
    """Probability that a plot beside a road has a building."""
    building_length: Range = (10.0, 24.0)
    """Length of a plot along the road [m]."""
    building_distance: Range = (0.5, 4.0)
    """Distance of a building from the sidewalk [m]."""
    speed_limits: tuple[float, ...] = (8.33, 11.1, 13.9)
    """Speed limits of the main street [m/s], each equally likely; a side street's is drawn from those up to its."""

    def __post_init__(self) -> None:
        """Refuse what makes no street."""
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "float" and not 0 <= value <= 1:
                raise ValueError(f"{field.name} is a probability: it must lie in [0, 1], not {value}")
            if field.type == "Range" and not (len(value) == 2 and 0 <= value[0] <= value[1] < 1000):
                raise ValueError(f"{field.name} must be (smallest, largest), not {value}")
            if field.type.startswith("tuple") and not value:
                raise ValueError(f"{field.name} is empty; name at least one")
        if unknown := set(self.layouts) - set(LAYOUTS):
            raise ValueError(f"layouts: there is no {unknown.pop()!r}; there are: {', '.join(LAYOUTS)}")
        for name in ("lanes", "arm_lanes"):
            if not all(1 <= lanes <= MOST_LANES for lanes in getattr(self, name)):
                raise ValueError(f"{name} must lie in [1, {MOST_LANES}], not {getattr(self, name)}")
        for name in ("angle", "skewed_angle"):
            low, high = getattr(self, name)
            if low < SHARPEST_ARM or high > 180 - SHARPEST_ARM:
                raise ValueError(f"{name} must lie in [{SHARPEST_ARM:g}, {180 - SHARPEST_ARM:g}] degrees")
        if not all(0 < limit <= FASTEST for limit in self.speed_limits):
            raise ValueError(f"speed_limits must be above 0 and at most {FASTEST} m/s, not {self.speed_limits}")

    @cached_property
    def hash(self) -> str:
        """The first 16 digits of the SHA-256 of all parameters. It is part of every street's random numbers."""
        text = json.dumps(asdict(self), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


TOWN = Town()
"""The family of training, validation and test."""
UNSEEN = Town(
    main_length=(172.0, 178.0),
    arm_length=(42.0, 48.0),
    block_length=(48.0, 53.0),
    angle=(62.0, 74.0),
    skewed_angle=(48.0, 56.0),
    curvature=(1 / 55, 1 / 38),
    lane_width=(2.75, 2.95),
    median_width=(3.2, 4.0),
    parking_width=(2.4, 2.6),
    kerb_radius=(9.5, 12.0),
    sidewalk_width=(1.6, 2.1),
    crosswalks=(0.0, 0.4),
    middle_crosswalks=(0.0, 0.2),
    crosswalk_width=(5.2, 6.5),
    zone_length=(6.0, 10.0),
    building_length=(26.0, 40.0),
    building_distance=(0.0, 0.4),
    speed_limits=(6.94, 9.72, 12.5),
)
"""Streets none of whose ranges meets `TOWN`'s: for tests of what was never trained."""
ARTERIAL = Town(
    layouts=("straight", "tee", "cross", "staggered"),
    main_length=(165.0, 178.0),
    curvature=(0.0, 1 / 250),
    lanes=(2,),
    arm_lanes=(1,),
    lane_width=(3.25, 3.5),
    one_way=0.0,
    median=0.5,
    parking=0.8,
    crosswalks=(0.0, 0.3),
    middle_crosswalks=(0.2, 0.5),
    unmarked=0.0,
    raised=0.0,
    zone_length=(30.0, 50.0),
    speed_limits=(13.9,),
)
"""Wide, fast streets: two lanes in each direction, 50 km/h, few crosswalks, and people who cross far away from them."""
PARKED = Town(
    lanes=(1,),
    arm_lanes=(1,),
    lane_width=(2.75, 3.0),
    median=0.0,
    parking=1.0,
    zone_length=(18.0, 30.0),
    speed_limits=(13.9,),
)
"""Narrow streets of two lanes between parking strips, where 50 km/h are allowed: parked vehicles hide whoever
jaywalks, and stand close to the car."""
