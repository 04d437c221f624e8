"""How scripted people walk: along a way of their own, at any place, from the moment for which they wait."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.sim.crossing_kind import JAYWALK, LegKind
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.script import Script, Trigger
from jaxwalk.sim.state import Leg, PedestrianState, VehicleState
from jaxwalk.sim.vehicle import room
from jaxwalk.sim.world import World

WAITS = -1.0
"""The time since somebody began to walk, before that [s]."""
STILL = 1e-3
"""A car slower than this never arrives [m/s]."""
SHORTEST = 1e-6
"""Times, ways and speeds below this are none."""


def stand(world: World, scenario: Scenario) -> PedestrianState:
    """Return scripted people where they begin. Who waits for nothing has just set out."""
    script = _script(scenario)
    sets_out = (script.trigger == Trigger.TIME) & (script.waits_for <= 0)
    since = jnp.where(sets_out, jnp.zeros_like(script.waits_for), WAITS)
    return _people(world, scenario, since, jnp.ones(sets_out.shape, bool))


def set_out(
    world: World, scenario: Scenario, time: Float[Array, "*batch"], car: VehicleState, people: PedestrianState
) -> PedestrianState:
    """Return people at a moment [s]; who waited for it has set out, exactly when it came.

    The car is taken to have kept its speed since then, but for no longer than a step.
    """
    script = _script(scenario)
    way = script.place - car.along[None]
    arrival = way / jnp.maximum(car.speed, STILL)[None]
    since = jnp.where(
        script.trigger == Trigger.TIME,
        time[None] - script.waits_for,
        jnp.where(
            script.trigger == Trigger.DISTANCE,
            (script.waits_for - way) / jnp.maximum(car.speed, STILL)[None],
            script.waits_for - arrival,
        ),
    )
    assert people.since is not None
    comes = (people.since < 0) & (since >= 0)
    return replace(people, since=jnp.where(comes, jnp.minimum(since, world.rules.dt), people.since))


def walk_freely(
    world: World, scenario: Scenario, people: PedestrianState, go: Bool[Array, "ped *batch"]
) -> PedestrianState:
    """Make one step: people who have set out and go walk on along their way, to its end; all others stand."""
    since = people.since
    assert since is not None
    return _people(world, scenario, jnp.where(go & (since >= 0), since + world.rules.dt, since), go)


def pace_of_script(script: Script, people: PedestrianState) -> Float[Array, "ped *batch"]:
    """Return the speed of people who go [m/s]: while they gather it, what they have; before that, what they will."""
    assert people.since is not None
    return pace_of(script, people.since)


def pace_of(script: Script, since: Float[Array, "ped *batch"]) -> Float[Array, "ped *batch"]:
    """Return the speed of people who go [m/s] and have set out this long ago [s]."""
    gathers = (since >= 0) & (since < _run_up_time(script))
    own = jnp.where(gathers, script.pace * since / jnp.maximum(_run_up_time(script), SHORTEST), script.pace)
    if script.path_time is None:
        return own
    begin, end, left, reached = _timed_piece(script, script.path_time, since)
    timed = jnp.where(reached > left, (end - begin) / jnp.maximum(reached - left, SHORTEST), 0)
    return jnp.where(script.path_time[-1] > 0, timed, own)


def _people(
    world: World, scenario: Scenario, since: Float[Array, "ped *batch"], go: Bool[Array, "ped *batch"]
) -> PedestrianState:
    """Return people who set out this long ago [s]."""
    script = _script(scenario)
    length = script.path_along[-1]
    along = jnp.minimum(_walked(script, since), length)
    number = (script.path_along[1:-1] <= along[None]).sum(axis=0)
    x, y, begin = (_point(column, number) for column in (script.path_x, script.path_y, script.path_along))
    end_x, end_y, end = (_point(column, number + 1) for column in (script.path_x, script.path_y, script.path_along))
    divisor = jnp.maximum(end - begin, SHORTEST)
    none = jnp.zeros_like(scenario.start)
    # Scripted people follow no graph: wherever they are on a roadway, even on a crosswalk, they count as jaywalking.
    leg = Leg(
        end_x=end_x, end_y=end_y, cos=(end_x - x) / divisor, sin=(end_y - y) / divisor, length=end - begin,
        kind=none + LegKind.SIDEWALK, node=none, side=none, begin=jnp.zeros_like(along),
        road_end=jnp.full_like(along, -1), kerb_past_end=script.kerb - end, crossing=none + JAYWALK,
        decisions=none + 1, goal=none, arrivals=none,
    )  # fmt: skip
    remaining = end - along
    inside, _, _ = room(world, scenario, end_x - leg.cos * remaining, end_y - leg.sin * remaining)
    no = jnp.zeros(go.shape, bool)
    going = go & (since >= 0) & (along < length)
    if script.path_time is not None:
        going &= pace_of(script, since) > 0
    return PedestrianState(
        leg=leg, following=leg, planned=no, remaining=remaining, going=going,
        on_roadway=inside > 0, on_crosswalk=no, since=since,
    )  # fmt: skip


def _point(column: Float[Array, "point ped *batch"], number: Int[Array, "ped *batch"]) -> Float[Array, "ped *batch"]:
    """Return each person's own entry of a column of points."""
    return jnp.take_along_axis(column, number[None], axis=0, mode="promise_in_bounds")[0]


def _walked(script: Script, since: Float[Array, "ped *batch"]) -> Float[Array, "ped *batch"]:
    """Return how far people have walked who set out this long ago [m], if their way is long enough."""
    time, gathering = jnp.maximum(since, 0), _run_up_time(script)
    share = time / jnp.maximum(gathering, SHORTEST)
    own = jnp.where(time < gathering, script.run_up * share**2, script.run_up + script.pace * (time - gathering))
    if script.path_time is None:
        return own
    begin, end, left, reached = _timed_piece(script, script.path_time, since)
    passed = jnp.clip((time - left) / jnp.maximum(reached - left, SHORTEST), 0, 1)
    return jnp.where(script.path_time[-1] > 0, begin + passed * (end - begin), own)


def _timed_piece(
    script: Script, path_time: Float[Array, "point ped *batch"], since: Float[Array, "ped *batch"]
) -> tuple[Array, Array, Array, Array]:
    """Return where the piece of their way that people are on begins and ends [m along it], and when [s]."""
    number = (path_time[1:-1] <= since[None]).sum(axis=0)
    begin, left = (_point(column, number) for column in (script.path_along, path_time))
    end, reached = (_point(column, number + 1) for column in (script.path_along, path_time))
    return begin, end, left, reached


def _run_up_time(script: Script) -> Float[Array, "ped *batch"]:
    """Return how long people gather speed [s]: on the run-up they are half as fast as after it."""
    return 2 * script.run_up / jnp.maximum(script.pace, SHORTEST)


def _script(scenario: Scenario) -> Script:
    assert scenario.script is not None
    return scenario.script
