"""Play a batch of scenarios to their ends, and record it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import count
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int, Key

from jaxwalk.acting import Given, act, cast_of, fresh_memory, step_key
from jaxwalk.evaluation.broken import ActionError
from jaxwalk.evaluation.hosted import ask
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.policies.host import HostDriver
from jaxwalk.policies.shielding import Intervention, Shielded
from jaxwalk.sim import vehicle
from jaxwalk.sim.environment import Street
from jaxwalk.sim.prediction import AWAY
from jaxwalk.sim.recording import Frame, frame, parked_boxes
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import State
from jaxwalk.sim.trajectory import Trajectory, in_order

BLOCK = 25
"""Steps between two checks whether all episodes have ended. Half of them, on average, are played for nobody."""


class Setup(eqx.Module):
    """What stays the same while a batch of episodes is played."""

    street: Street
    policies: Roles[Policy]
    scenarios: Scenario
    keys: Key[Array, "episode"]
    until: Int[Array, "episode"]
    """The last step of each episode."""


class Underway(eqx.Module):
    """A batch of episodes in progress. An episode that has ended does not change any more."""

    state: State
    memory: Roles[tuple[Any, ...]]
    """The policies' memories. They go on after an episode's end, so that no policy plans again at each idle step."""
    ended: Bool[Array, "episode"]
    goal: Bool[Array, "episode"]
    collision: Bool[Array, "episode"]
    touched: Bool[Array, "ped episode"]
    actions: Roles[Array]
    """The last actions. One that isn't in its space ends the episode."""
    shield: Intervention | None
    """What the driver's shield did in the last step; None without one."""


class Endings(NamedTuple):
    """How episodes ended, or how they are so far."""

    length: Int[np.ndarray, "episode"]
    """Steps played."""
    goal: Bool[np.ndarray, "episode"]
    collision: Bool[np.ndarray, "episode"]
    touched: Bool[np.ndarray, "ped episode"]

    @staticmethod
    def of(game: Underway) -> Endings:
        """Return those of a batch."""
        return Endings(*map(np.asarray, (game.state.step, game.goal, game.collision, game.touched)))


def play(
    street: Street,
    policies: Roles[Policy],
    scenarios: Scenario,
    keys: Key[Array, "episode"],
    *,
    numbers: Int[np.ndarray, "episode"] | None = None,
    until: Int[np.ndarray, "episode"] | None = None,
) -> Trajectory:
    """Play every scenario to its end. This compiles once for each street, kinds of policy and batch size.

    Args:
        street: the world.
        policies: the policy of each role. A `HostDriver` is asked between steps, all others act within the compiled
            program.
        scenarios: a batch, arrays ``(..., episode)``.
        keys: one key for each episode; a policy's draws depend only on the key and the step.
        numbers: numbers of the scenarios, for the trajectory's ``scenario`` (default: 0, 1, ...).
        until: the step at which each episode is cut off, unless it has ended before; one that is cut off has no ending
            (default: the horizon).

    Returns:
        Frames up to the longest episode's end. After its own end, an episode repeats its last frame.

    Raises:
        ValueError: ``keys`` is not a batch, or its length differs from the scenarios'; or there are two `HostDriver`s.
        DriverError: a `HostDriver` failed.
        ActionError: an action of another policy isn't in its space.
    """
    if keys.ndim != 1 or scenarios.route.shape != keys.shape:
        shapes = f"keys {keys.shape}, scenarios {scenarios.route.shape}"
        raise ValueError(f"play needs a batch of scenarios and one key for each, not: {shapes}")
    numbers = np.arange(len(keys)) if numbers is None else np.asarray(numbers)
    host = host_driver(policies)
    setup, game, first = begin(street, policies, scenarios, keys, until)
    blocks = [{name: np.asarray(x)[None] for name, x in first.items()}]
    rest = _play(setup, game) if host is None else _ask_and_play(setup, policies, host, game, numbers)
    for after, frames in rest:
        game = after
        blocks.append({name: np.asarray(x) for name, x in frames.items()})
    check_actions(street, game, numbers)
    endings = Endings.of(game)
    frames = int(endings.length.max()) + 1
    columns = {name: np.concatenate([block[name] for block in blocks])[:frames] for name in first}
    return recording(street, scenarios, numbers, endings, columns)


def begin(
    street: Street,
    policies: Roles[Policy],
    scenarios: Scenario,
    keys: Key[Array, "episode"],
    until: Int[np.ndarray, "episode"] | None = None,
) -> tuple[Setup, Underway, Frame]:
    """Return what stays the same in a batch of episodes, their start, and its frame 0: what `play_block` goes on from.

    A `HostDriver` is replaced by a `Given`, which stands still until `answered` puts its answer there. The arguments
    are those of `play`.
    """
    last = np.full(keys.shape, street.world.rules.horizon) if until is None else until
    host = host_driver(policies)
    compiled = policies if host is None else answered(policies, Given(street.roles["driver"].zeros(keys.shape)))
    setup = Setup(street, compiled, scenarios, keys, jnp.asarray(last, jnp.int32))
    game, first = _begin(street, fresh_memory(street, cast_of(compiled), keys.shape), scenarios)
    if isinstance(policies["driver"], Shielded):
        game = replace(game, shield=Intervention(jnp.zeros_like(game.ended), jnp.zeros_like(game.ended)))
        first |= _frame_of_shield(game)
    return setup, game, first


def host_driver(policies: Roles[Policy]) -> HostDriver | None:
    """Return the driver that cannot be compiled, wherever it is in the policies; None if there is none."""
    hosts = {id(x): x for x in jax.tree.leaves(policies) if isinstance(x, HostDriver)}
    if len(hosts) > 1:
        names = " and ".join(host.name for host in hosts.values())
        raise ValueError(f"play can ask one driver that isn't written in JAX, not {names}; let one of them drive")
    return next(iter(hosts.values()), None)


def _play(setup: Setup, game: Underway) -> Iterator[tuple[Underway, Frame]]:
    """Yield block after block, until all episodes have ended."""
    while not bool(game.ended.all()):
        game, frames = play_block(setup, game, BLOCK)
        yield game, frames


def answered(policies: Roles[Policy], answer: Given) -> Roles[Policy]:
    """Return the policies with an answer in place of the driver that cannot be compiled, wherever it is in them."""
    return jax.tree.map(lambda x: answer if isinstance(x, HostDriver) else x, policies)


def _ask_and_play(
    setup: Setup, policies: Roles[Policy], driver: HostDriver, game: Underway, numbers: np.ndarray
) -> Iterator[tuple[Underway, Frame]]:
    """Play step after step; each step starts with the driver's answer to what it observes."""
    with driver.lock:
        driver.init((), game.ended.shape)
        steps = count()
        while (playing := ~np.asarray(game.ended)).any():
            seen = setup.street.observe(setup.scenarios, game.state, driver.view)
            answer = ask(driver, seen, playing=playing, numbers=numbers, step=next(steps))
            setup = eqx.tree_at(lambda setup: setup.policies, setup, answered(policies, answer))
            game, frames = play_block(setup, game, 1)
            yield game, frames


def check_actions(street: Street, game: Underway, numbers: Int[np.ndarray, "episode"]) -> None:
    """Raise ActionError for the first episode that an action outside its space has ended."""
    for _, error in unsound_actions(street, game, numbers):
        raise error


def unsound_actions(
    street: Street, game: Underway, numbers: Int[np.ndarray, "episode"]
) -> Iterator[tuple[int, ActionError]]:
    """Yield the place of each episode that an action outside its space has ended, and the error that says so."""
    for role, spec in street.roles.items():
        actions = np.asarray(game.actions[role])
        for episode in np.flatnonzero(~spec.contains(actions)):
            scenario, step = int(numbers[episode]), int(game.state.step[episode]) - 1
            yield int(episode), ActionError.of(role, spec, actions[..., episode], scenario=scenario, step=step)


_goal = eqx.filter_jit(vehicle.goal)


@eqx.filter_jit
def _begin(street: Street, memory: Roles[tuple[Any, ...]], scenarios: Scenario) -> tuple[Underway, Frame]:
    """Return the start of every episode, and its frame 0."""
    state = street.reset(scenarios)
    no = jnp.zeros(state.step.shape, bool)
    nobody = jnp.zeros(scenarios.start.shape, bool)
    actions = {role: spec.zeros(state.step.shape) for role, spec in street.roles.items()}
    return Underway(state, memory, no, no, no, nobody, actions, None), frame(street.world, scenarios, state)


def _frame_of_shield(game: Underway) -> Frame:
    did = game.shield
    return {} if did is None else {"shield_changed": did.changed, "shield_infeasible": did.infeasible}


@eqx.filter_jit
def play_block(setup: Setup, game: Underway, steps: int) -> tuple[Underway, Frame]:
    """Return the episodes after this number of steps, and the steps' frames along a leading axis."""

    def body(game: Underway, _: None) -> tuple[Underway, Frame]:
        game = _step(setup, game)
        return game, frame(setup.street.world, setup.scenarios, game.state) | _frame_of_shield(game)

    return jax.lax.scan(body, game, None, length=steps)


def _step(setup: Setup, game: Underway) -> Underway:
    """Make one step in every episode that has not ended."""
    street, cast = setup.street, cast_of(setup.policies)
    key = step_key(setup.keys, game.state.step)
    acted = act(street, cast, key, setup.scenarios, _alone_where(game.ended, game.state), game.memory)
    state, outcome = street.step(setup.scenarios, game.state, acted.actions)
    sound = [spec.contains(acted.actions[role]) for role, spec in street.roles.items()]
    events, ended = outcome.events, outcome.ended | (state.step >= setup.until) | ~jnp.stack(sound).all(axis=0)
    actions = jax.tree.map(lambda new, old: new.astype(old.dtype), acted.actions, game.actions)
    (did,) = acted.records["driver"]
    after = Underway(state, acted.memory, ended, events.goal, events.collision, events.touched, actions, did)
    kept = jax.tree.map(lambda new, old: jnp.where(game.ended, old, new), after, game)
    return eqx.tree_at(lambda game: game.memory, kept, acted.memory, is_leaf=lambda x: x is None)


def _alone_where(ended: Bool[Array, "episode"], state: State) -> State:
    """Return the states in which, once an episode has ended, nobody is near its car: no shield searches for a way."""
    people = state.foresight.people
    ahead = jnp.where(ended, AWAY, people.ahead)
    return replace(state, foresight=replace(state.foresight, people=replace(people, ahead=ahead)))


def recording(
    street: Street,
    scenarios: Scenario,
    numbers: Int[np.ndarray, "episode"],
    endings: Endings,
    columns: dict[str, np.ndarray],
) -> Trajectory:
    """Return the recording of the first episodes, as many as have ``endings``, in the order frame, episode, pedestrian.

    The ``columns`` are frames ``(frame, episode)`` or ``(frame, ped, episode)``.
    """
    some = slice(len(endings.length))
    goal_x, goal_y = _goal(street.world, scenarios)
    parked = parked_boxes(street.world, scenarios)
    return Trajectory(
        dt=street.world.rules.dt,
        scenario=numbers[some],
        length=endings.length,
        goal=endings.goal,
        collision=endings.collision,
        touched=endings.touched.T,
        goal_x=np.asarray(goal_x)[some],
        goal_y=np.asarray(goal_y)[some],
        jaywalking_tendency=np.asarray(scenarios.jaywalking_tendency(street.world)).T[some],
        parked=None if parked is None else parked[some],
        **in_order(columns),
    )
