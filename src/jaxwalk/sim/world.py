"""What is the same in every episode: the maps and the rules."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from jaxwalk.maps import MapText, RoadMap, build_map, each_map, read_map, stack_maps
from jaxwalk.sim.kerbsides import pack_kerbsides
from jaxwalk.sim.map_tables import Tables, pack_tables, shortest_crossing
from jaxwalk.sim.occluders import pack_occluders
from jaxwalk.sim.parked_gaps import pack_parked_gaps
from jaxwalk.sim.person_kind import PersonKind
from jaxwalk.sim.sim_config import ContactRule, SimConfig

STATIC = (
    "dt", "horizon", "substeps", "pedestrians", "contact", "kinds", "pace_correlation", "earlier_decisions", "grouped",
    "perception", "delay", "position_noise", "misses",
)  # fmt: skip
"""The rules that a compiled step contains as constants, because loops, shapes or its code depend on them."""
CROSSINGS = (1.25, 2.5, 5.0, 10.0, 20.0)
"""With several maps, tables are sized for the next of these below their shortest crossing [m]."""


class Rules(eqx.Module):
    """The numbers of a `SimConfig`, which documents them and their units.

    Another value of an array needs no new compilation, unless it changes the size of a table (``fastest_walk``,
    ``goal_spacing``, ``start_clearance`` and ``sight`` can), or ``parked`` becomes 0 or stops being 0.
    """

    dt: float = eqx.field(static=True)
    horizon: int = eqx.field(static=True)
    substeps: int = eqx.field(static=True)
    pedestrians: int = eqx.field(static=True)
    contact: ContactRule = eqx.field(static=True)
    kinds: tuple[PersonKind, ...] = eqx.field(static=True)
    pace_correlation: float = eqx.field(static=True)
    earlier_decisions: int = eqx.field(static=True)
    grouped: float = eqx.field(static=True)
    perception: bool = eqx.field(static=True)
    delay: float = eqx.field(static=True)
    position_noise: float = eqx.field(static=True)
    misses: float = eqx.field(static=True)
    slowest_walk: Float[Array, ""]
    fastest_walk: Float[Array, ""]
    wheelbase: Float[Array, ""]
    max_speed: Float[Array, ""]
    max_steering: Float[Array, ""]
    max_acceleration: Float[Array, ""]
    max_braking: Float[Array, ""]
    max_lateral: Float[Array, ""]
    offroad_margin: Float[Array, ""]
    offroad_speed: Float[Array, ""]
    collision_distance: Float[Array, ""]
    car_length: Float[Array, ""]
    car_width: Float[Array, ""]
    body_radius: Float[Array, ""]
    goal_distance: Float[Array, ""]
    moving_speed: Float[Array, ""]
    start_clearance: Float[Array, ""]
    goal_spacing: Float[Array, ""]
    kerb_distance: Float[Array, ""]
    jaywalk_multiplier: Float[Array, ""]
    parked: Float[Array, ""]
    sight: Float[Array, ""]

    @property
    def config(self) -> SimConfig:
        """The plain numbers again. Only outside compiled code."""
        numbers: dict[str, Any] = {name: as_written(getattr(self, name)) for name in _names_of_arrays()}
        return SimConfig(**{name: getattr(self, name) for name in STATIC}, **numbers)


class MapTexts(tuple[MapText, ...]):
    """The texts of a world's maps. All are equal, so that what is compiled for some maps serves others of their sizes.

    So a compiled function mustn't return a world: its texts would be those of the world it was compiled for.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        """Return whether the other is a `MapTexts` too."""
        return isinstance(other, MapTexts)

    def __ne__(self, other: object) -> bool:
        """Return whether the other isn't a `MapTexts`."""
        return not isinstance(other, MapTexts)

    def __hash__(self) -> int:
        """Return the same for all."""
        return hash(MapTexts)


class World(eqx.Module):
    """Everything that is the same in all episodes. Functions of the simulator take it whole."""

    maps: RoadMap
    """Stacked maps; a scenario names one."""
    tables: Tables
    """The same maps, packed for a step."""
    rules: Rules
    goals: int = eqx.field(static=True)
    """How many goals a scenario holds for each pedestrian."""
    crossings: int = eqx.field(static=True)
    """How many crossings a scenario holds draws for, for each pedestrian."""
    slots: int = eqx.field(static=True)
    """How many parking slots a scenario decides about: 0 if nobody ever parks."""
    map_count: Int[Array, ""]
    """How many of the stacked maps are drawn from; further ones only round up their number."""
    map_texts: MapTexts = eqx.field(static=True)
    """Name, hash and text of each map."""
    occluders: tuple[Float[Array, "map row column box"], ...] | None = None
    """What can hide people, by the car's place, a table for each of `jaxwalk.sim.occluders.COLUMNS`; None where
    everybody sees everybody."""
    parked_gaps: Float[Array, "map side vehicle 5"] | None = None
    """Where parked vehicles are in the way of jaywalks (`jaxwalk.sim.parked_gaps`); None where nobody ever parks."""
    kerbsides: Float[Array, "map route point 5"] | None = None
    """What lies beside the routes (`jaxwalk.sim.kerbsides`); None where everybody sees everybody."""

    @classmethod
    def create(cls, maps: Sequence[str | Path | MapText], config: SimConfig) -> World:
        """Return the world of some maps (names as `read_map` and `each_map` take them, or texts).

        Raise MapError for a wrong map, and ValueError for roads that are too narrow for ``offroad_margin``.
        """
        spacing = {"goal_spacing": config.goal_spacing, "start_clearance": config.start_clearance}
        each = [one for x in maps for one in ([x] if isinstance(x, MapText) else each_map([x]))]
        texts = tuple(x if isinstance(x, MapText) else read_map(x) for x in each)
        named = zip(texts, map(str, each), strict=True)  # an error names a file as the caller did
        several = len(texts) > 1
        stacked = stack_maps([build_map(x.text or "", name, **spacing) for x, name in named], rounded=several)
        _check_margin(stacked, config.offroad_margin)
        packed, shortest = pack_tables(stacked, config), shortest_crossing(stacked)
        if several:  # so that another set of maps has tables of the same sizes
            shortest = max(x for x in CROSSINGS if x <= max(shortest, CROSSINGS[0]))
        goals, crossings = table_sizes(config, shortest_crossing=shortest)
        numbers = {name: np.float32(getattr(config, name)) for name in _names_of_arrays()}
        hides, beside = None, None
        if config.perception:
            hides, beside = pack_occluders(stacked, config.sight), pack_kerbsides(stacked)
        slots = stacked.slots.shape[-2] if config.parked > 0 else 0
        in_the_way = pack_parked_gaps(stacked, packed, config.body_radius) if slots else None
        on_host = (hides, in_the_way, beside, stacked, packed, numbers, np.int32(len(texts)))
        # `jnp.asarray` compiles one program per shape
        occluders, parked_gaps, kerbsides, road_map, tables, arrays, count = jax.device_put(on_host)
        static: dict[str, Any] = {name: getattr(config, name) for name in STATIC}
        rules = Rules(**static, **arrays)
        sizes = (goals, crossings, slots, count, MapTexts(texts))
        return cls(road_map, Tables(**tables), rules, *sizes, occluders, parked_gaps, kerbsides)


def table_sizes(config: SimConfig, *, shortest_crossing: float) -> tuple[int, int]:
    """Return how many goals and how many crossings the fastest pedestrian could need.

    It walks at most horizon x dt x top speed. Between two decisions lies at least one crossing, ``shortest_crossing``
    metres long. Goals are ``goal_spacing`` apart along the graph; a jaywalk is shorter, but no shorter than a crossing.
    """
    reach = config.horizon * config.dt * config.fastest
    apart = min(config.goal_spacing, shortest_crossing)
    return 2 + math.floor(reach / apart), 2 + math.floor(reach / shortest_crossing)


def _check_margin(maps: RoadMap, margin: float) -> None:
    """Raise ValueError if no place of some road is ``margin`` [m] inside it."""
    most = float(np.min(maps.half_width))
    if margin > most:
        raise ValueError(f"offroad_margin must be at most half the narrowest road's width, {most:g} m, not {margin:g}")


def as_written(number: Array) -> float:
    """Return a single-precision number as somebody wrote it: 8.33, not 8.329999923706055."""
    return float(str(np.float32(number)))


def _names_of_arrays() -> list[str]:
    """Return the fields of a `SimConfig` that `Rules` holds as arrays."""
    return [field.name for field in fields(SimConfig) if field.name not in STATIC]
