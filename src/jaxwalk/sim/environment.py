"""The street: draw a scenario, reset, observe, step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.interfaces import Box, Discrete, Moment, Outcome, Roles, RoleSpec, View
from jaxwalk.maps import RoadMap, load_map, stack_maps
from jaxwalk.sim import observation, pedestrian, reward, scenario, vehicle
from jaxwalk.sim.config import JAYWALK_MULTIPLIER, SimConfig
from jaxwalk.sim.events import arrives, touches
from jaxwalk.sim.prediction import foresee
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState, State, VehicleState
from jaxwalk.sim.tables import Tables, pack_tables


class Events(eqx.Module):
    """What ended an episode, if anything did. In one step: collision before goal before timeout."""

    collision: Bool[Array, "*batch"]
    goal: Bool[Array, "*batch"]
    timeout: Bool[Array, "*batch"]
    touched: Bool[Array, "ped *batch"]
    """Whom the car collided with."""


class Street(eqx.Module):
    """Streets with a car and people who may jaywalk (an `Environment`). Make one with `Street.create`."""

    maps: RoadMap
    """Stacked maps; a scenario names one."""
    tables: Tables
    jaywalk_multiplier: Float[Array, ""]
    weights: Roles[dict[str, Float[Array, ""]]]
    """Weights of the reward terms that are paid, by role."""
    config: SimConfig = eqx.field(static=True)

    @classmethod
    def create(
        cls,
        maps: Sequence[str | Path] = ("paper",),
        config: SimConfig | None = None,
        *,
        jaywalk_multiplier: float = JAYWALK_MULTIPLIER,
        driver_weights: Mapping[str, float] | None = None,
        pedestrian_weights: Mapping[str, float] | None = None,
    ) -> Street:
        """A street on the given maps (bundled names or files), paying the given reward terms (default: none).

        Raises MapError for a wrong map, ValueError for a reward term that doesn't exist or a negative multiplier.
        """
        config = config or SimConfig()
        spacing = {"goal_spacing": config.goal_spacing, "start_clearance": config.start_clearance}
        stacked = stack_maps([load_map(name, **spacing) for name in maps])
        weights = {"driver": dict(driver_weights or {}), "pedestrian": dict(pedestrian_weights or {})}
        reward.check_weights(weights["driver"], weights["pedestrian"])
        if not 0 <= jaywalk_multiplier < float("inf"):
            raise ValueError(f"jaywalk_multiplier must be 0 or more, not {jaywalk_multiplier}")
        on_host = (stacked, np.float32(jaywalk_multiplier), jax.tree.map(np.float32, weights))
        road_map, multiplier, paid = jax.device_put(on_host)  # `jnp.asarray` compiles a program for each shape
        return cls(road_map, pack_tables(stacked), multiplier, paid, config)

    @property
    def roles(self) -> Roles[RoleSpec]:
        """One car with acceleration and steering; people who wait (0) or go (1)."""
        return {"driver": RoleSpec((), Box(2)), "pedestrian": RoleSpec((self.config.pedestrians,), Discrete(2))}

    def view(self, role: str, name: str) -> View:
        """Return a flat view by its name (`jaxwalk.sim.observation.OBSERVATIONS`). Raise ValueError if unknown."""
        return observation.Observation(role, name)

    @eqx.filter_jit
    def draw(self, key: Key[Array, ""], like: Scenario | None = None) -> Scenario:
        """One scenario; for a batch, ``jax.vmap(street.draw, out_axes=-1)(keys)``.

        ``like``: other people, but the map, start and goal of this scenario.
        """
        sizes = scenario.table_sizes(self.config, shortest_crossing=self.tables.shortest_crossing)
        return scenario.draw(self.maps, self.config, sizes, key, like)

    @eqx.filter_jit
    def reset(self, scenario: Scenario) -> State:
        """Car and people at their starts, standing."""
        zero = jnp.zeros_like(scenario.map)
        return self._state(scenario, zero, vehicle.place(self.tables, scenario), pedestrian.place(self.maps, scenario))

    @eqx.filter_jit
    def refreshed(self, scenario: Scenario, state: State) -> State:
        """A state in which somebody was moved by hand, with what follows from places and speeds worked out again."""
        course = vehicle.course(self.tables, scenario, state.vehicle.along)
        car = eqx.tree_at(lambda car: car.course, state.vehicle, course)
        return self._state(scenario, state.step, car, state.pedestrian)

    @eqx.filter_jit
    def observe(self, scenario: Scenario, state: State, view: View) -> Any:
        """Return what a view shows."""
        return view(Moment(self, scenario, state))

    @eqx.filter_jit
    def global_state(self, scenario: Scenario, state: State) -> Float[Array, "feature *batch"]:
        """What the paper's centralised critic sees."""
        return observation.global_state(self.maps, self.tables, self.config, scenario, state)

    @eqx.filter_jit
    def step(self, scenario: Scenario, state: State, actions: Roles[Array]) -> tuple[State, Outcome]:
        """One step: everybody moves, then events, then rewards. Deterministic; never resets."""
        car = vehicle.drive(self.maps, self.tables, self.config, scenario, state.vehicle, actions["driver"])
        people = pedestrian.walk(
            self.maps, self.tables, self.config, self.jaywalk_multiplier, scenario, state.pedestrian,
            actions["pedestrian"].astype(bool),
        )  # fmt: skip
        after = self._state(scenario, state.step + 1, car, people)
        events = self._events(scenario, after)
        transition = reward.Transition(self.tables, self.config, scenario, state, after, events)
        over = events.collision | events.goal
        ended = over | events.timeout
        return after, Outcome(
            rewards={
                "driver": reward.reward(reward.DRIVER_TERMS, self.weights["driver"], transition),
                "pedestrian": reward.reward(reward.PEDESTRIAN_TERMS, self.weights["pedestrian"], transition),
            },
            terminated={"driver": over, "pedestrian": events.touched},
            truncated={"driver": events.timeout, "pedestrian": ended[None] & ~events.touched},
            ended=ended,
            events=events,
        )

    def _state(self, scenario: Scenario, step: Array, car: VehicleState, people: PedestrianState) -> State:
        return State(step, car, people, foresee(self.config, scenario, car, people))

    def _events(self, scenario: Scenario, state: State) -> Events:
        car, people = state.vehicle, state.pedestrian
        touched = touches(people.x - car.x[None], people.y - car.y[None], self.config.collision_distance)
        goal_x, goal_y = vehicle.goal(self.tables, scenario)
        collision = touched.any(axis=0)
        goal = arrives(car.x - goal_x, car.y - goal_y, self.config.goal_distance) & ~collision
        timeout = (state.step >= self.config.horizon) & ~collision & ~goal
        return Events(collision=collision, goal=goal, timeout=timeout, touched=touched)
