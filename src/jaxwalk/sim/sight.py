"""Who is in sight: the straight line from the car's front axle, unless a parked vehicle or a building is in the way."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import or_

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, UInt32

from jaxwalk.sim.lookup import look_up_rows, once
from jaxwalk.sim.occluders import CELL, LANES, NO_SLOT, PADDING, meets
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import VehicleState
from jaxwalk.sim.world import World

BITS = 32
"""Slots of a word."""
NOTHING = -1e6
"""Half the length of what isn't there [m]."""


def in_sight(
    world: World, scenario: Scenario, car: VehicleState, x: Float[Array, "ped *batch"], y: Float[Array, "ped *batch"]
) -> Bool[Array, "ped *batch"]:
    """Return whether the line between the car's front axle and each place (x, y) [m] is free, and within ``sight``.

    Here the batch leads and boxes come last, `LANES` at a time: so each box is worked out once for all places, and the
    rows of the tables aren't transposed, which would take longer than to look them up.
    """
    eye_x = car.x + world.rules.wheelbase / 2 * car.cos
    eye_y = car.y + world.rules.wheelbase / 2 * car.sin
    dx, dy = x - eye_x[None], y - eye_y[None]
    to_x, to_y = (jnp.moveaxis(to, 0, -1)[..., None] for to in (dx, dy))

    def is_behind(box: tuple[Array, ...]) -> Array:
        ahead, aside, cos, sin, half_length, half_width = box
        return meets(to_x * cos + to_y * sin, to_y * cos - to_x * sin, ahead, aside, half_length, half_width)

    boxes = _boxes_near(world, scenario, eye_x, eye_y)
    turns = zip(*(jnp.split(column, column.shape[-1] // LANES, axis=-1) for column in boxes), strict=True)
    hidden = reduce(or_, map(is_behind, turns)).any(axis=-1)
    return ~jnp.moveaxis(once(hidden), -1, 0) & (dx * dx + dy * dy <= world.rules.sight**2)


def _boxes_near(
    world: World, scenario: Scenario, x: Float[Array, "*batch"], y: Float[Array, "*batch"]
) -> tuple[Float[Array, "*batch 1 box"], ...]:
    """Return the boxes that matter at a place (`jaxwalk.sim.occluders`), as seen from there.

    The columns are where its centre is along the box and to the left, its direction, and half its length and width.
    Where nothing stands, the length is below 0, and no line meets it.
    """
    tables = world.occluders
    assert tables is not None
    rows, columns = tables[0].shape[1:3]
    row, column = (jnp.clip((at / CELL).astype(jnp.int32), 0, most - 1) for at, most in ((y, rows), (x, columns)))
    entries = look_up_rows(tables, scenario.map, row, column)
    if scenario.script is not None:
        entries = _with_scripted(entries, scenario.script.boxes)
    box_x, box_y, cos, sin, half_length, half_width, slot = entries
    to_x, to_y = box_x - x[..., None], box_y - y[..., None]
    half_length = jnp.where(_stands(_words(scenario), slot), half_length, NOTHING)
    boxes = (to_x * cos + to_y * sin, to_y * cos - to_x * sin, cos, sin, half_length, half_width)
    return tuple(column[..., None, :] for column in boxes)


def _with_scripted(
    entries: Sequence[Float[Array, "*batch _"]], boxes: Float[Array, "box 6 *batch"]
) -> list[Float[Array, "*batch _"]]:
    """Return the columns of the table's entries with the boxes of a script after them, padded to whole turns."""
    always = jnp.full_like(boxes[:, 0], NO_SLOT)
    missing = [(0, 0)] * (boxes.ndim - 2) + [(0, -len(boxes) % LANES)]
    scripted = (
        jnp.pad(jnp.moveaxis(column, 0, -1), missing, constant_values=PADDING)
        for column in (*jnp.unstack(boxes, axis=1), always)
    )
    return [jnp.concatenate(pair, axis=-1) for pair in zip(entries, scripted, strict=True)]


def _words(scenario: Scenario) -> tuple[UInt32[Array, "*batch"], ...]:
    """Return which slots are occupied, as bits of words of `BITS` slots."""
    if scenario.parked is None:
        return ()
    slots, *batch = scenario.parked.shape
    short = -slots % BITS
    bits = jnp.pad(scenario.parked, ((0, short), *((0, 0),) * len(batch))).reshape(-1, BITS, *batch)
    weights = (jnp.uint32(1) << jnp.arange(BITS, dtype=jnp.uint32)).reshape(-1, *(1,) * len(batch))
    return tuple((bits * weights).sum(axis=1, dtype=jnp.uint32))


def _stands(words: tuple[UInt32[Array, "*batch"], ...], slot: Float[Array, "*batch box"]) -> Bool[Array, "*batch box"]:
    """Return whether a building, or a vehicle in this slot, stands there."""
    number = jnp.maximum(slot, 0).astype(jnp.uint32)
    word = jnp.zeros(slot.shape, jnp.uint32)
    for index, bits in enumerate(words):
        word = jnp.where(number // BITS == index, bits[..., None], word)
    return (slot == NO_SLOT) | ((slot >= 0) & ((word >> (number % BITS)) & 1 == 1))
