"""Everybody moves for one step: the car, and then people; in several parts where the rules say so."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.interfaces import Roles
from jaxwalk.sim import pedestrian, vehicle
from jaxwalk.sim.events import contact_gap, touching
from jaxwalk.sim.free_walk import set_out
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState, State, VehicleState
from jaxwalk.sim.world import Rules, World

DEPTH = 1e-3
"""With substeps, an episode ends when car and body overlap by this [m], so that rounding doesn't undo the contact."""


class Moved(eqx.Module):
    """Where everybody is, and who was touched by the car."""

    car: VehicleState
    people: PedestrianState
    touched: Bool[Array, "ped *batch"]


def move(world: World, scenario: Scenario, state: State, actions: Roles[Array]) -> Moved:
    """Return where everybody is after a step, or at the moment of a contact if a step has several parts."""
    rules, begins = world.rules, state.step * world.rules.dt
    drive, go = actions["driver"], actions["pedestrian"].astype(bool)
    if rules.substeps == 1:
        car, people = _once(world, scenario, begins, (state.vehicle, state.pedestrian), (drive, go))
        return Moved(car, people, touched_by(rules, car, people))
    finely = replace(world, rules=replace(rules, dt=rules.dt / rules.substeps))

    def part(before: Moved, number: Array) -> tuple[Moved, None]:
        time = begins + number * finely.rules.dt
        car, people = _once(finely, scenario, time, (before.car, before.people), (drive, go))
        after = _at_contact(rules, before, Moved(car, people, touched_by(rules, car, people)))
        over = before.touched.any(axis=0)
        return jax.tree.map(lambda old, new: jnp.where(over, old, new), before, after), None

    nobody = jnp.zeros(go.shape, bool)
    start = Moved(state.vehicle, state.pedestrian, nobody)
    return jax.lax.scan(part, start, jnp.arange(rules.substeps))[0]


def touched_by(rules: Rules, car: VehicleState, people: PedestrianState) -> Bool[Array, "ped *batch"]:
    """Return who is touched by the car, by the contact that ends episodes."""
    return touching(rules, people.x - car.x[None], people.y - car.y[None], car.cos[None], car.sin[None])


def _once(
    world: World,
    scenario: Scenario,
    time: Float[Array, "*batch"],
    at: tuple[VehicleState, PedestrianState],
    actions: tuple[Array, Array],
) -> tuple[VehicleState, PedestrianState]:
    """Return car and people after a step that begins at a time [s]."""
    (car, people), (drive, go) = at, actions
    if scenario.script is not None:
        people = set_out(world, scenario, time, car, people)
    return vehicle.drive(world, scenario, car, drive), pedestrian.walk(world, scenario, people, go)


def _at_contact(rules: Rules, before: Moved, after: Moved) -> Moved:
    """Return the moment between two at which the first contact begins; the later one without a contact."""
    gaps = [
        contact_gap(rules, x.people.x - x.car.x[None], x.people.y - x.car.y[None], x.car.cos[None], x.car.sin[None])
        for x in (before, after)
    ]
    closed = jnp.where(after.touched, (gaps[0] + DEPTH) / jnp.maximum(gaps[0] - gaps[1], 1e-9), jnp.inf)
    between = _between(before, after, jnp.clip(closed.min(axis=0, initial=1.0), 0, 1))
    touched = touched_by(rules, between.car, between.people)
    met = touched.any(axis=0)
    between = replace(between, touched=touched)
    return jax.tree.map(lambda exact, late: jnp.where(met, exact, late), between, after)


def _between(before: Moved, after: Moved, share: Float[Array, "*batch"]) -> Moved:
    """Return where everybody is after this share of a step. Who has begun another leg is where the step ends."""

    def mixed(old: Array, new: Array) -> Array:
        return old + share * (new - old)

    moving = ("x", "y", "cos", "sin", "speed", "along")
    car = {name: mixed(getattr(before.car, name), getattr(after.car, name)) for name in moving}
    old, new = before.people, after.people
    same = (old.leg.end_x == new.leg.end_x) & (old.leg.end_y == new.leg.end_y)
    remaining = jnp.where(same, mixed(old.remaining, new.remaining), new.remaining)
    since = None if old.since is None or new.since is None else mixed(old.since, new.since)
    return Moved(
        replace(after.car, **car),
        replace(new, remaining=remaining, since=since),
        after.touched,
    )
