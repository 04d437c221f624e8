"""The street: draw a scenario, reset, observe, step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.interfaces import Box, Discrete, Moment, Outcome, Roles, RoleSpec, View
from jaxwalk.maps import MapText
from jaxwalk.sim import cost, observation, pedestrian, reward, scenario, vehicle
from jaxwalk.sim.events import Events, arrives
from jaxwalk.sim.kept_points import KeptPoints
from jaxwalk.sim.movement import move
from jaxwalk.sim.perceived import Perceived
from jaxwalk.sim.perception import first_perceived, perceive
from jaxwalk.sim.prediction import foresee, unhidden
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.state import PedestrianState, State, VehicleState
from jaxwalk.sim.world import World


class Street(eqx.Module):
    """Streets with a car and people who may jaywalk (an `Environment`). Make one with `Street.create`."""

    world: World
    weights: Roles[dict[str, Float[Array, ""]]]
    """The weights of the reward terms that are paid, by role and name."""
    costs: tuple[str, ...] = eqx.field(static=True, default=())
    """Names of the car's costs that are counted (`jaxwalk.sim.cost.DRIVER_COSTS`)."""
    kept: dict[int, KeptPoints] = eqx.field(default_factory=dict)
    """Scenarios that are mixed into those that are drawn, by the number of people."""

    @classmethod
    def create(
        cls,
        maps: Sequence[str | Path | MapText] = ("paper",),
        config: SimConfig | None = None,
        *,
        jaywalk_multiplier: float | None = None,
        driver_weights: Mapping[str, float] | None = None,
        pedestrian_weights: Mapping[str, float] | None = None,
        driver_costs: Sequence[str] = (),
    ) -> Street:
        """Return a street on the maps that pays the given reward terms and counts the given costs (default: none).

        Maps are bundled names, files, generated streets (``test:20``, ``test-2000000003``; docs/streets.md) or texts.
        A ``jaywalk_multiplier`` replaces that of ``config``.

        Raise MapError for a wrong map, and ValueError for a reward term or a cost that doesn't exist, a negative
        multiplier, or roads that are too narrow for ``offroad_margin``.
        """
        weights = {"driver": dict(driver_weights or {}), "pedestrian": dict(pedestrian_weights or {})}
        reward.check_weights(weights["driver"], weights["pedestrian"])
        cost.check_costs(driver_costs)
        rules = config or SimConfig()
        if jaywalk_multiplier is not None:
            rules = replace(rules, jaywalk_multiplier=jaywalk_multiplier)
        world = World.create(maps, rules)
        return cls(world, jax.device_put(jax.tree.map(np.float32, weights)), tuple(driver_costs))

    @property
    def config(self) -> SimConfig:
        """The rules as plain numbers. Only outside compiled code, which reads ``world.rules``."""
        return self.world.rules.config

    @property
    def maps(self) -> tuple[MapText, ...]:
        """Name, hash and text of each map, in the order of `Scenario.map`."""
        return tuple(self.world.map_texts)

    @property
    def roles(self) -> Roles[RoleSpec]:
        """One car with acceleration and steering; people who, at every step and anywhere, stand (0) or go (1)."""
        return {"driver": RoleSpec((), Box(2)), "pedestrian": RoleSpec((self.world.rules.pedestrians,), Discrete(2))}

    def view(self, role: str, name: str) -> View:
        """Return a flat view by its name (`jaxwalk.sim.observation.OBSERVATIONS`). Raise ValueError if unknown."""
        return observation.Observation(role, name)

    def with_people(self, people: int) -> Street:
        """Return the street with another number of people in an episode: the same tables, but another program.

        Raise ValueError for an impossible number.
        """
        rules = self.world.rules
        replace(rules.config, pedestrians=people)  # it refuses an impossible number
        return replace(self, world=replace(self.world, rules=replace(rules, pedestrians=people)))

    @eqx.filter_jit
    def draw(self, key: Key[Array, ""], like: Scenario | None = None) -> Scenario:
        """Draw one scenario; for a batch, ``jax.vmap(street.draw, out_axes=-1)(keys)``.

        ``like``: keep this scenario's map, start and goal of the car, but draw other people.
        """
        return scenario.draw(self.world, key, like, self.kept.get(self.world.rules.pedestrians))

    @eqx.filter_jit
    def reset(self, scenario: Scenario) -> State:
        """Return car and people at their starts; nobody has moved yet."""
        zero = jnp.zeros_like(scenario.map)
        car, people = vehicle.place(self.world, scenario), pedestrian.place(self.world, scenario)
        knows = first_perceived(self.world, scenario, car, people) if self.world.rules.perception else None
        return self._state(scenario, zero, car, people, knows)

    @eqx.filter_jit
    def observe(self, scenario: Scenario, state: State, view: View) -> Any:
        """Return what a view shows."""
        return view(Moment(self.world, scenario, state))

    def unhidden(self, scenario: Scenario, state: State) -> State:
        """Return the state as if nothing hid anybody; the state itself where everybody sees everybody."""
        return unhidden(Moment(self.world, scenario, state)).state

    @eqx.filter_jit
    def global_state(self, scenario: Scenario, state: State) -> Float[Array, "feature *batch"]:
        """Return what the paper's centralised critic sees."""
        return observation.global_state(Moment(self.world, scenario, state))

    @eqx.filter_jit
    def step(self, scenario: Scenario, state: State, actions: Roles[Array]) -> tuple[State, Outcome]:
        """Make one step: everybody moves, the car perceives and foresees people, then come events, then rewards.

        It is deterministic and never resets.
        """
        moved = move(self.world, scenario, state, actions)
        car, people = moved.car, moved.people
        knows = state.perceived
        if knows is not None:
            knows = perceive(self.world, scenario, state.step + 1, car, people, knows)
        after = self._state(scenario, state.step + 1, car, people, knows)
        events = self._events(scenario, after, moved.touched)
        transition = reward.Transition(self.world, scenario, state, after, events)
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
            costs={"driver": cost.counted(self.costs, transition)} if self.costs else {},
        )

    def _state(
        self, scenario: Scenario, step: Array, car: VehicleState, people: PedestrianState, knows: Perceived | None
    ) -> State:
        return State(step, car, people, foresee(self.world, scenario, car, people, knows), knows)

    def _events(self, scenario: Scenario, state: State, touched: Bool[Array, "ped *batch"]) -> Events:
        car, rules = state.vehicle, self.world.rules
        goal_x, goal_y = vehicle.goal(self.world, scenario)
        collision = touched.any(axis=0)
        goal = arrives(car.x - goal_x, car.y - goal_y, rules.goal_distance) & ~collision
        timeout = (state.step >= rules.horizon) & ~collision & ~goal
        return Events(collision=collision, goal=goal, timeout=timeout, touched=touched)
