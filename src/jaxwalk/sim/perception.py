"""What the car perceives of people, step after step: between the truth and every driver's view.

A scenario, a step and a person decide what is missed and how far a position is off, so a step stays deterministic.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax.scipy.special import ndtri
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.sim import pedestrian
from jaxwalk.sim.crossing_kind import JAYWALK, NO_CROSSING
from jaxwalk.sim.perceived import KEPT, CrossingsSeen, Perceived, Sighting
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sight import in_sight
from jaxwalk.sim.state import PedestrianState, VehicleState
from jaxwalk.sim.world import World

NEVER = 1e6
"""The age of what was never seen [s]."""
MISSED, TO_EAST, TO_NORTH = 0, 1, 2
"""What chance decides about a sighting."""


def first_perceived(world: World, scenario: Scenario, car: VehicleState, people: PedestrianState) -> Perceived:
    """Return what the car perceives at the start, as if car and people had long stood there."""
    seen_by, now = _look(world, scenario, jnp.zeros_like(scenario.map), car, people)
    nobody = Sighting(*(jnp.zeros_like(column) for column in jax.tree.leaves(now)))
    none = jnp.zeros_like(now.decisions)
    steps = round(world.rules.delay / world.rules.dt)
    before = Perceived(
        in_sight=seen_by,
        now=nobody,
        last=nobody,
        age=jnp.full_like(now.x, NEVER),
        crossings=CrossingsSeen(none, none, none),
        on_the_way=jax.tree.map(lambda column: jnp.broadcast_to(column, (steps, *column.shape)), now)
        if steps
        else None,
    )
    return _arrive(world, before, seen_by, now)


def perceive(
    world: World, scenario: Scenario, step: Int[Array, "*batch"], car: VehicleState, people: PedestrianState,
    before: Perceived,
) -> Perceived:  # fmt: skip
    """Return what the car perceives after a step; ``before`` is what it perceived before it."""
    return _arrive(world, before, *_look(world, scenario, step, car, people))


def _look(
    world: World, scenario: Scenario, step: Int[Array, "*batch"], car: VehicleState, people: PedestrianState
) -> tuple[Bool[Array, "ped *batch"], Sighting]:
    """Return who is in sight, and how the sensors see them."""
    x, y, rules = people.x, people.y, world.rules
    visible = in_sight(world, scenario, car, x, y)
    velocity_x, velocity_y = pedestrian.velocity(world, scenario, people)
    seen = visible
    if rules.misses > 0:
        seen = visible & (chance(scenario, step, MISSED) >= rules.misses)
    if rules.position_noise > 0:
        x = x + rules.position_noise * ndtri(chance(scenario, step, TO_EAST))
        y = y + rules.position_noise * ndtri(chance(scenario, step, TO_NORTH))
    crossing = jnp.where(people.on_roadway, people.crossing, NO_CROSSING)
    decisions = jnp.where(people.may_jaywalk, people.decisions, 0)
    columns = (x, y, velocity_x, velocity_y, people.on_roadway, crossing, decisions)
    return visible, Sighting(seen, *(jnp.where(seen, column, jnp.zeros_like(column)) for column in columns))


def _arrive(world: World, before: Perceived, visible: Bool[Array, "ped *batch"], sent: Sighting) -> Perceived:
    """Return what the driver knows when the oldest sighting on the way arrives, and ``sent`` is the newest."""
    rules, now, waiting, late = world.rules, sent, before.on_the_way, 0
    if waiting is not None:
        late = len(waiting.x)
        waiting = jax.tree.map(lambda old, new: jnp.concatenate([old, new[None]]), waiting, sent)
        now, waiting = jax.tree.map(lambda all_of: all_of[0], waiting), jax.tree.map(lambda all_of: all_of[1:], waiting)
    age = jnp.where(now.seen, late * rules.dt, jnp.minimum(before.age + rules.dt, NEVER))
    last = jax.tree.map(lambda new, old: jnp.where(now.seen, new, old), now, before.last)
    known = Sighting(age <= KEPT, *jax.tree.leaves(last)[1:])
    return Perceived(visible, now, known, age, _counted(before.crossings, now), waiting)


def _counted(before: CrossingsSeen, now: Sighting) -> CrossingsSeen:
    """Return the crossings seen so far: each counts once, when the person is first seen on the roadway."""
    crosses = now.seen & now.on_roadway & (now.crossing != NO_CROSSING) & (now.decisions > before.last)
    jaywalks = crosses & (now.crossing == JAYWALK)
    return CrossingsSeen(
        before.jaywalks + jaywalks,
        before.crosswalks + (crosses & ~jaywalks),
        jnp.where(crosses, now.decisions, before.last),
    )


def chance(scenario: Scenario, step: Int[Array, "*batch"], what: int) -> Float[Array, "ped *batch"]:
    """Return a number in (0, 1) that depends on the scenario, the step, the person and ``what``, and looks random.

    The traits of a person are mixed with step and ``what`` by the finaliser of MurmurHash3 (Appleby 2011), twice.
    """
    words = jax.lax.bitcast_convert_type(scenario.traits, jnp.uint32)
    person = jnp.arange(words.shape[1], dtype=jnp.uint32).reshape(-1, *(1,) * step.ndim)
    mixed = _mix(person * jnp.uint32(3) + jnp.uint32(what + 1))
    for word in (*jnp.unstack(words), step.astype(jnp.uint32)[None]):
        mixed = _mix(mixed ^ word)
    return ((mixed >> 9).astype(jnp.float32) + 0.5) / 2**23


def _mix(word: Array) -> Array:
    word = (word ^ (word >> 16)) * jnp.uint32(0x85EBCA6B)
    word = (word ^ (word >> 13)) * jnp.uint32(0xC2B2AE35)
    return word ^ (word >> 16)
