"""Playing a batch of scenarios to their ends, and recording it."""

from __future__ import annotations

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int, Key

from jaxwalk.interfaces import ByRole, Policy
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


class Game(eqx.Module):
    """A batch of episodes under way. An episode that has ended stays as it is."""

    state: State
    memory: ByRole[Any]
    """What the policies remember."""
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
) -> Trajectory:
    """Play every scenario to its end. Compiles once for each street, kinds of policy and batch size.

    Args:
        street: the world.
        driver: decides for the car.
        pedestrians: decides for all people.
        scenarios: a batch, arrays ``(..., episode)``.
        keys: one for each episode; what a policy draws depends on it and on the step alone.
        numbers: the trajectory's ``scenario``; 0, 1, ... if left out.

    Returns:
        Frames up to the longest episode's end. After its own end an episode's frames repeat its last one.

    Raises:
        ValueError: ``keys`` is no batch, or not as long as the scenarios' batch.
    """
    if keys.ndim != 1 or scenarios.route.shape != keys.shape:
        shapes = f"keys {keys.shape}, scenarios {scenarios.route.shape}"
        raise ValueError(f"play needs a batch of scenarios and one key for each, not: {shapes}")
    policies = ByRole(driver, pedestrians)
    game, first = _begin(street, _fresh_memory(street, policies, keys.shape), scenarios)
    blocks = [{name: np.asarray(x)[None] for name, x in first.items()}]
    while not bool(game.ended.all()):
        game, frames = _play_block(street, policies, scenarios, keys, game)
        blocks.append({name: np.asarray(x) for name, x in frames.items()})
    return _trajectory(street, scenarios, game, blocks, numbers)


_goal = eqx.filter_jit(vehicle.goal)


def _fresh_memory(street: Street, policies: ByRole[Policy], batch: tuple[int, ...]) -> ByRole[Any]:
    roles = street.roles
    return ByRole(
        policies.driver.init(roles.driver.agents, batch), policies.pedestrian.init(roles.pedestrian.agents, batch)
    )


@eqx.filter_jit
def _begin(street: Street, memory: ByRole[Any], scenarios: Scenario) -> tuple[Game, Frame]:
    """The start of every episode, and its frame 0."""
    state = street.reset(scenarios)
    no = jnp.zeros(state.step.shape, bool)
    nobody = jnp.zeros(scenarios.start.shape, bool)
    return Game(state, memory, no, no, no, nobody), _frame(street, scenarios, state)


@eqx.filter_jit
def _play_block(
    street: Street, policies: ByRole[Policy], scenarios: Scenario, keys: Key[Array, "episode"], game: Game
) -> tuple[Game, Frame]:
    """``BLOCK`` steps, and their frames along a leading axis."""

    def body(game: Game, _: None) -> tuple[Game, Frame]:
        game = _step(street, policies, scenarios, keys, game)
        return game, _frame(street, scenarios, game.state)

    return jax.lax.scan(body, game, None, length=BLOCK)


def _step(
    street: Street, policies: ByRole[Policy], scenarios: Scenario, keys: Key[Array, "episode"], game: Game
) -> Game:
    """One step of every episode that has not ended."""
    actions, memory = _act(street, policies, scenarios, keys, game)
    state, outcome = street.step(scenarios, game.state, actions)
    events = outcome.events
    after = Game(state, memory, outcome.ended, events.goal, events.collision, events.touched)
    return jax.tree.map(lambda new, old: jnp.where(game.ended, old, new), after, game)


def _act(
    street: Street, policies: ByRole[Policy], scenarios: Scenario, keys: Key[Array, "episode"], game: Game
) -> tuple[ByRole[Array], ByRole[Any]]:
    """Everybody's actions and next memories; keys are made from episode, step and role."""
    now = jax.vmap(jax.random.fold_in)(keys, FIRST_ACTION_KEY + game.state.step)
    driver_key, pedestrian_key = jax.vmap(jax.random.split, out_axes=1)(now)
    driver, pedestrians = policies.driver, policies.pedestrian
    seen_by_driver = street.observe(scenarios, game.state, "driver", driver.observes)
    seen_by_people = street.observe(scenarios, game.state, "pedestrian", pedestrians.observes)
    drive, driver_memory = driver.act(driver_key, game.memory.driver, seen_by_driver)
    walk, people_memory = pedestrians.act(pedestrian_key, game.memory.pedestrian, seen_by_people)
    return ByRole(drive, walk), ByRole(driver_memory, people_memory)


def _frame(street: Street, scenarios: Scenario, state: State) -> Frame:
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
        "at_kerb": pedestrian.at_kerb(street.config, people),
        "enters_roadway": pedestrian.enters_roadway(people),
        "going": people.going,
        "predicted_miss": prediction.predicted_miss(street.config, scenarios, state)[0],
    }


def frame_of_people(street: Street, scenarios: Scenario, people: PedestrianState) -> Frame:
    """Where people are, how they move, and how they cross."""
    velocity_x, velocity_y = pedestrian.velocity(street.config, scenarios, people)
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
    numbers: Int[np.ndarray, "episode"] | None,
) -> Trajectory:
    """The recording in the order frame, episode, pedestrian."""
    length = np.asarray(game.state.step)
    frames = int(length.max()) + 1
    columns = {name: np.concatenate([block[name] for block in blocks])[:frames] for name in blocks[0]}
    goal_x, goal_y = _goal(street.tables, scenarios)
    return Trajectory(
        dt=street.config.dt,
        scenario=np.arange(len(length)) if numbers is None else np.asarray(numbers),
        length=length,
        goal=np.asarray(game.goal),
        collision=np.asarray(game.collision),
        touched=np.asarray(game.touched).T,
        goal_x=np.asarray(goal_x),
        goal_y=np.asarray(goal_y),
        jaywalking_tendency=np.asarray(scenarios.jaywalking_tendency).T,
        **{name: x.swapaxes(1, 2) if x.ndim == 3 else x for name, x in columns.items()},
    )
