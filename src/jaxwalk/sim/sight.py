"""Who is in sight: the straight line from the car's front axle, unless a parked vehicle or a building is in the way."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import or_

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, UInt32

from jaxwalk.platforms import few_launches
from jaxwalk.sim.lookup import look_up_rows
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

    Here the batch leads and boxes come last, `LANES` at a time, as in the rows of the tables: to transpose these would
    take longer than to look them up.
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
    return ~jnp.moveaxis(hidden, -1, 0) & (dx * dx + dy * dy <= world.rules.sight**2)


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
    standing = _standing(scenario.parked, slot, half_length)
    boxes = (to_x * cos + to_y * sin, to_y * cos - to_x * sin, cos, sin, standing, half_width)
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


def _words(parked: Bool[Array, "slot *batch"]) -> UInt32[Array, "word *batch"]:
    """Return which slots are occupied, as bits of words of `BITS` slots."""
    slots, *batch = parked.shape
    short = -slots % BITS
    bits = jnp.pad(parked, ((0, short), *((0, 0),) * len(batch))).reshape(-1, BITS, *batch)
    weights = (jnp.uint32(1) << jnp.arange(BITS, dtype=jnp.uint32)).reshape(-1, *(1,) * len(batch))
    return (bits * weights).sum(axis=1, dtype=jnp.uint32)


def _standing(
    parked: Bool[Array, "slot *batch"] | None, slot: Float[Array, "*batch box"], half_length: Float[Array, "*batch box"]
) -> Float[Array, "*batch box"]:
    """Return half the lengths of boxes, `NOTHING` of those that pad a row and of free slots.

    It is a loop, so that a CPU stores the result instead of working it out again for each person.
    """
    if parked is None:
        return jnp.where(slot == NO_SLOT, half_length, NOTHING)
    number, words = slot.astype(jnp.int32), _words(parked)

    def clear(index: Array, found: Array) -> Array:
        bits = words[index][..., None] >> (number % BITS).astype(jnp.uint32)
        return jnp.where((number // BITS == index) & (bits & 1 == 0), NOTHING, found)

    begin = jnp.where(slot == PADDING, NOTHING, half_length)
    return jax.lax.fori_loop(0, len(words), clear, begin, unroll=few_launches())
