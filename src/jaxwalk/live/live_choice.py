"""What a page of `jaxwalk live` may ask for, checked before anything is done with it."""

from __future__ import annotations

from typing import Annotated, Literal

import pydantic
from pydantic import Field
from pydantic.dataclasses import dataclass as checked

from jaxwalk.scenarios.drawn import NUMBERS, SEEDS
from jaxwalk.sim.sim_config import LARGEST

EXACT = pydantic.ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
SLOWEST, FASTEST = 1.0, 30.0
"""Limits of the top speed that can be chosen [m/s], where no file of scenarios has another one."""
MOST_JAYWALKS = 10.0
"""Largest jaywalk multiplier that can be chosen, where no file of scenarios has a larger one."""
LONGEST = 4_000
"""Longest message of a page, in bytes."""

Share = Annotated[float, Field(ge=-1, le=1)]


class LiveError(ValueError):
    """What a page asks for can't be done. The message says why, in one line."""


@checked(frozen=True, config=EXACT)
class LiveChoice:
    """A scenario and who plays it. A dial of None is as the world, or the file of scenarios, has it."""

    street: str
    world: str
    places: Annotated[int, Field(ge=1)]
    """For how many people the simulation is compiled, and scenarios are drawn."""
    driver: str
    pedestrians: str
    seed: Annotated[int, Field(ge=0, lt=SEEDS)] = 0
    number: Annotated[int, Field(ge=0, lt=NUMBERS)] = 0
    """The scenario's number among those of the seed, or in the file of scenarios."""
    people: Annotated[int, Field(ge=0)] | None = None
    """How many of the people are there: the first ones. People who are left out of a file of scenarios don't count."""
    jaywalk_multiplier: Annotated[float, Field(ge=0)] | None = None
    max_speed: Annotated[float, Field(gt=0, le=LARGEST["max_speed"])] | None = None
    """The car's top speed [m/s]."""
    parked: Annotated[float, Field(gt=0, le=1)] | None = None
    """Share of the parking slots in which a vehicle stands and hides people."""


@checked(frozen=True, config=EXACT)
class Message:
    """What a page says."""

    do: Literal["open", "play", "pause", "step", "hand", "save"]
    choice: LiveChoice | None = None
    """open: what to open."""
    rate: Annotated[float, Field(ge=0.1, le=8)] = 1.0
    """play: seconds of the street in a second."""
    drives: bool = False
    """hand: whether a person drives."""
    pedal: Share = 0.0
    """hand: acceleration as a share of its limit, negative for braking."""
    steering: Share | None = None
    """hand: steering as a share of its limit, positive to the left; None follows the route."""


_MESSAGE = pydantic.TypeAdapter(Message)


def read_message(text: str | bytes) -> Message:
    """Return a page's message. Raise LiveError if it is none."""
    try:
        return _MESSAGE.validate_json(text)
    except pydantic.ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"])) or "message"
        raise LiveError(f"{where}: {first['msg']}") from error
