"""Who is in sight: the straight line from the car's front axle, unless a parked vehicle or a building is in the way."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, UInt32

from jaxwalk.sim.everybody import for_everybody
from jaxwalk.sim.lookup import look_up_row
from jaxwalk.sim.occluders import CELL, COLUMNS, NO_SLOT, meets
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import VehicleState
from jaxwalk.sim.world import World

BITS = 32
"""Slots of a word."""


def in_sight(
    world: World, scenario: Scenario, car: VehicleState, x: Float[Array, "ped *batch"], y: Float[Array, "ped *batch"]
) -> Bool[Array, "ped *batch"]:
    """Return whether the line between the car's front axle and each place (x, y) [m] is free, and within ``sight``."""
    eye_x = car.x + world.rules.wheelbase / 2 * car.cos
    eye_y = car.y + world.rules.wheelbase / 2 * car.sin
    dx, dy = x - eye_x[None], y - eye_y[None]
    boxes, words = _boxes_near(world, scenario, eye_x, eye_y), _words(scenario)

    def look_past(box: tuple[Array, ...], hidden: Array) -> Array:
        bx, by, cos, sin, half_length, half_width, slot = box
        to_x, to_y = bx - eye_x[None], by - eye_y[None]
        along, left = dx * cos + dy * sin, dy * cos - dx * sin
        ahead, aside = to_x * cos + to_y * sin, to_y * cos - to_x * sin
        return hidden | (_stands(words, slot) & meets(along, left, ahead, aside, half_length, half_width))

    hidden = for_everybody(boxes, look_past, jnp.zeros(dx.shape, bool))
    return ~hidden & (dx * dx + dy * dy <= world.rules.sight**2)


def _boxes_near(world: World, scenario: Scenario, x: Array, y: Array) -> tuple[Float[Array, "box *batch"], ...]:
    """Return the columns of the boxes that matter at a place (`jaxwalk.sim.occluders`)."""
    table = world.occluders
    assert table is not None
    rows, columns = table.shape[1:3]
    row, column = (jnp.clip((at / CELL).astype(jnp.int32), 0, most - 1) for at, most in ((y, rows), (x, columns)))
    entries = look_up_row(table, scenario.map, row, column)
    boxes = tuple(jnp.moveaxis(entries.reshape(-1, COLUMNS, *x.shape), 1, 0))
    return boxes if scenario.script is None else _with_scripted(boxes, scenario.script.boxes)


def _with_scripted(
    boxes: tuple[Float[Array, "_ *batch"], ...], scripted: Float[Array, "box 6 *batch"]
) -> tuple[Float[Array, "_ *batch"], ...]:
    """Return the columns of boxes with those of a script after them."""
    always = jnp.full(scripted[:, :1].shape, NO_SLOT)
    columns = jnp.moveaxis(jnp.concatenate([scripted, always], axis=1), 1, 0)
    return tuple(jnp.concatenate(pair) for pair in zip(boxes, columns, strict=True))


def _words(scenario: Scenario) -> tuple[UInt32[Array, "*batch"], ...]:
    """Return which slots are occupied, as bits of words of `BITS` slots."""
    if scenario.parked is None:
        return ()
    slots, *batch = scenario.parked.shape
    short = -slots % BITS
    bits = jnp.pad(scenario.parked, ((0, short), *((0, 0),) * len(batch))).reshape(-1, BITS, *batch)
    weights = (jnp.uint32(1) << jnp.arange(BITS, dtype=jnp.uint32)).reshape(-1, *(1,) * len(batch))
    return tuple((bits * weights).sum(axis=1, dtype=jnp.uint32))


def _stands(words: tuple[UInt32[Array, "*batch"], ...], slot: Float[Array, "1 *batch"]) -> Bool[Array, "1 *batch"]:
    """Return whether a building, or a vehicle in this slot, stands there."""
    number = jnp.maximum(slot, 0).astype(jnp.uint32)
    word = jnp.zeros(slot.shape, jnp.uint32)
    for index, bits in enumerate(words):
        word = jnp.where(number // BITS == index, bits[None], word)
    return (slot == NO_SLOT) | ((slot >= 0) & ((word >> (number % BITS)) & 1 == 1))
