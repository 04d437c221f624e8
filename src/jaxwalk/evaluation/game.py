"""Playing a batch of scenarios to their ends, and recording it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int, Key

from jaxwalk.evaluation.hosted import Answered, ask
from jaxwalk.evaluation.interventions import Intervention, Now
from jaxwalk.interfaces import ByRole, Policy
from jaxwalk.policies.host import HostDriver
from jaxwalk.rollout import FIRST_ACTION_KEY
from jaxwalk.sim import pedestrian, prediction, vehicle
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState, State
from jaxwalk.sim.trajectory import Trajectory

BLOCK = 100
"""Steps played between two looks at whether all episodes have ended."""

Frame = dict[str, Array]
"""What is recorded of a moment, by the names of `Trajectory`; arrays ``(episode,)`` or ``(ped, episode)``."""


class Setup(eqx.Module):
    """What stays the same while a batch of episodes is played."""

    street: Street
    policies: ByRole[Policy]
    intervention: Intervention | None
    scenarios: Scenario
    keys: Key[Array, "episode"]
    until: Int[Array, "episode"]
    """The last step of each episode."""


class Game(eqx.Module):
    """A batch of episodes under way. An episode that has ended stays as it is."""

    state: State
    memory: ByRole[Any]
    """What the policies remember."""
    intervening: Any
    """What the intervention remembers."""
    ended: Bool[Array, "episode"]
    goal: Bool[Array, "episode"]
    collision: Bool[Array, "episode"]
    touched: Bool[Array, "ped episode"]


def play(
    street: Street,
    driver: Policy,
    pedestrians: Policy,
    scenarios: Scenario,
    keys: Key[Array, "episode"],
    *,
    numbers: Int[np.ndarray, "episode"] | None = None,
    intervention: Intervention | None = None,
    until: Int[np.ndarray, "episode"] | None = None,
) -> Trajectory:
    """Play every scenario to its end. Compiles once for each street, kinds of policy and batch size.

    Args:
        street: the world.
        driver: decides for the car. A `HostDriver` is asked between steps, everybody else within the compiled program.
        pedestrians: decides for all people.
        scenarios: a batch, arrays ``(..., episode)``.
        keys: one for each episode; what a policy draws depends on it and on the step alone.
        numbers: the trajectory's ``scenario``; 0, 1, ... if left out.
        intervention: changes actions (`jaxwalk.evaluation.interventions`); each kind of it compiles once more.
        until: the last step of each episode, if it has not ended by then; such an episode has no ending. If left out,
            the horizon.

    Returns:
        Frames up to the longest episode's end. After its own end an episode's frames repeat its last one.

    Raises:
        ValueError: ``keys`` is no batch, or not as long as the scenarios' batch.
        DriverError: a `HostDriver` failed.
    """
    if keys.ndim != 1 or scenarios.route.shape != keys.shape:
        shapes = f"keys {keys.shape}, scenarios {scenarios.route.shape}"
        raise ValueError(f"play needs a batch of scenarios and one key for each, not: {shapes}")
    last = np.full(keys.shape, street.world.rules.horizon) if until is None else until
    numbers = np.arange(len(keys)) if numbers is None else np.asarray(numbers)
    compiled = Answered.nothing(driver.observes, keys.shape) if isinstance(driver, HostDriver) else driver
    policies = ByRole(compiled, pedestrians)
    setup = Setup(street, policies, intervention, scenarios, keys, jnp.asarray(last, jnp.int32))
    intervening = None if intervention is None else intervention.init(keys.shape)
    game, first = _begin(street, _fresh_memory(street, policies, keys.shape), intervening, scenarios)
    blocks = [{name: np.asarray(x)[None] for name, x in first.items()}]
    rest = _ask_and_play(setup, game, driver, numbers) if isinstance(driver, HostDriver) else _play(setup, game)
    for after, frames in rest:
        game = after
        blocks.append({name: np.asarray(x) for name, x in frames.items()})
    return _trajectory(street, scenarios, game, blocks, numbers)


def _play(setup: Setup, game: Game) -> Iterator[tuple[Game, Frame]]:
    """Block after block, until all episodes have ended."""
    while not bool(game.ended.all()):
        game, frames = _play_block(setup, game, BLOCK)
        yield game, frames


def _ask_and_play(setup: Setup, game: Game, driver: HostDriver, numbers: np.ndarray) -> Iterator[tuple[Game, Frame]]:
    """Step after step likewise; each begins with what the driver answers to what it observes."""
    with driver.turn:
        driver.init((), game.ended.shape)
        for step in count():
            playing = ~np.asarray(game.ended)
            if not playing.any():
                return
            seen = setup.street.observe(setup.scenarios, game.state, "driver", driver.observes)
            answer = ask(driver, seen, playing=playing, numbers=numbers, step=step)
            setup = eqx.tree_at(lambda setup: setup.policies.driver, setup, answer)
            game, frames = _play_block(setup, game, 1)
            yield game, frames


_goal = eqx.filter_jit(vehicle.goal)


def _fresh_memory(street: Street, policies: ByRole[Policy], batch: tuple[int, ...]) -> ByRole[Any]:
    roles = street.roles
    return ByRole(
        policies.driver.init(roles.driver.agents, batch), policies.pedestrian.init(roles.pedestrian.agents, batch)
    )


@eqx.filter_jit
def _begin(street: Street, memory: ByRole[Any], intervening: Any, scenarios: Scenario) -> tuple[Game, Frame]:
    """The start of every episode, and its frame 0."""
    state = street.reset(scenarios)
    no = jnp.zeros(state.step.shape, bool)
    nobody = jnp.zeros(scenarios.start.shape, bool)
    return Game(state, memory, intervening, no, no, no, nobody), frame(street, scenarios, state)


@eqx.filter_jit
def _play_block(setup: Setup, game: Game, steps: int) -> tuple[Game, Frame]:
    """So many steps, and their frames along a leading axis."""

    def body(game: Game, _: None) -> tuple[Game, Frame]:
        game = _step(setup, game)
        return game, frame(setup.street, setup.scenarios, game.state)

    return jax.lax.scan(body, game, None, length=steps)


def _step(setup: Setup, game: Game) -> Game:
    """One step of every episode that has not ended."""
    actions, memory, intervening = _act(setup, game)
    state, outcome = setup.street.step(setup.scenarios, game.state, actions)
    events, ended = outcome.events, outcome.ended | (state.step >= setup.until)
    after = Game(state, memory, intervening, ended, events.goal, events.collision, events.touched)
    return jax.tree.map(lambda new, old: jnp.where(game.ended, old, new), after, game)


def _act(setup: Setup, game: Game) -> tuple[ByRole[Array], ByRole[Any], Any]:
    """Actions and next memories of everybody, and of the intervention; keys are made from episode, step and role."""
    street, scenarios, state = setup.street, setup.scenarios, game.state
    now = jax.vmap(jax.random.fold_in)(setup.keys, FIRST_ACTION_KEY + state.step)
    driver_key, pedestrian_key = jax.vmap(jax.random.split, out_axes=1)(now)
    driver, pedestrians = setup.policies.driver, setup.policies.pedestrian
    seen_by_driver = street.observe(scenarios, state, "driver", driver.observes)
    seen_by_people = street.observe(scenarios, state, "pedestrian", pedestrians.observes)
    drive, driver_memory = driver.act(driver_key, game.memory.driver, seen_by_driver)
    walk, people_memory = pedestrians.act(pedestrian_key, game.memory.pedestrian, seen_by_people)
    actions, memory, intervening = ByRole(drive, walk), ByRole(driver_memory, people_memory), None
    if setup.intervention is not None:
        moment = Now(street, scenarios, state, driver_key, ~game.ended)
        actions, intervening = setup.intervention.act(moment, game.intervening, actions)
    return actions, memory, intervening


def frame(street: Street, scenarios: Scenario, state: State) -> Frame:
    """What is recorded of a moment."""
    car, people = state.vehicle, state.pedestrian
    return {
        "car_x": car.x,
        "car_y": car.y,
        "car_cos": car.cos,
        "car_sin": car.sin,
        "car_speed": car.speed,
        "car_acceleration": car.acceleration,
        **frame_of_people(street, scenarios, people),
        "decisions": people.decisions.astype(jnp.int16),
        "at_kerb": pedestrian.at_kerb(street.world, people),
        "enters_roadway": pedestrian.enters_roadway(people),
        "going": people.going,
        "predicted_miss": prediction.predicted_miss(street.world, scenarios, state)[0],
    }


def frame_of_people(street: Street, scenarios: Scenario, people: PedestrianState) -> Frame:
    """Where people are, how they move, and how they cross."""
    velocity_x, velocity_y = pedestrian.velocity(street.world, scenarios, people)
    return {
        "ped_x": people.x,
        "ped_y": people.y,
        "ped_vx": velocity_x,
        "ped_vy": velocity_y,
        "on_roadway": people.on_roadway,
        "on_crosswalk": people.on_crosswalk,
        "crossing": people.crossing.astype(jnp.int8),
    }


def _trajectory(
    street: Street,
    scenarios: Scenario,
    game: Game,
    blocks: list[dict[str, np.ndarray]],
    numbers: Int[np.ndarray, "episode"],
) -> Trajectory:
    """The recording in the order frame, episode, pedestrian."""
    length = np.asarray(game.state.step)
    frames = int(length.max()) + 1
    columns = {name: np.concatenate([block[name] for block in blocks])[:frames] for name in blocks[0]}
    goal_x, goal_y = _goal(street.world, scenarios)
    return Trajectory(
        dt=street.world.rules.dt,
        scenario=numbers,
        length=length,
        goal=np.asarray(game.goal),
        collision=np.asarray(game.collision),
        touched=np.asarray(game.touched).T,
        goal_x=np.asarray(goal_x),
        goal_y=np.asarray(goal_y),
        jaywalking_tendency=np.asarray(scenarios.jaywalking_tendency).T,
        **{name: x.swapaxes(1, 2) if x.ndim == 3 else x for name, x in columns.items()},
    )
