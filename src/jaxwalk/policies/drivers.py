"""Rule-based drivers: `DRIVERS` are baselines for trained ones, and pedestrians train among `Careless`.

An action is (acceleration, steering), each a share of its limit in [-1, 1]; positive steering is to the left. The
rules assume the car's default limits (`SimConfig`); `world_numbers.with_limits` gives them those of another world.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.interfaces import Policy, View
from jaxwalk.policies.belief_planner import BeliefPlanner, chance_planner, cvar_planner
from jaxwalk.policies.careful_human import CarefulHuman, careful_human_with_aeb
from jaxwalk.policies.cautious_rule import CautiousRule
from jaxwalk.policies.clearance_rule import ClearanceRule
from jaxwalk.policies.crosswalk_yield import CrosswalkYield
from jaxwalk.policies.fuzzy_safety import FuzzySafety
from jaxwalk.policies.idm_yield import IdmYield
from jaxwalk.policies.oracle import Oracle
from jaxwalk.policies.pursuit import pursue
from jaxwalk.policies.world_numbers import from_world
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import Observation, part
from jaxwalk.sim.prediction import DISTANCE, NEIGHBOURS
from jaxwalk.sim.sim_config import SimConfig

FULL_THROTTLE, FULL_BRAKING = 1.0, -1.0
"""Accelerations as shares of the limit (3 m/s2)."""

Features = Float[Array, "feature *batch"]
Action = Float[Array, "2 *batch"]


class Random(eqx.Module):
    """Draws acceleration and steering uniformly from [-1, 1], independently at every step."""

    view: View = eqx.field(static=True, default=Observation("driver", "paper"))
    """What it sees (it uses nothing)."""

    @property
    def sample(self) -> bool:
        """Always True: it draws every action."""
        return True

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(self, key: Key[Array, "*batch"], memory: None, observation: Features) -> tuple[Action, None]:
        """Return uniform actions, each episode's from its own key."""

        def draw(one: Key[Array, ""]) -> Float[Array, "2"]:
            return jax.random.uniform(one, (2,), minval=-1, maxval=1)

        for _ in range(key.ndim):
            draw = jax.vmap(draw, out_axes=-1)
        return draw(key), memory


class ConstantSpeed(eqx.Module):
    """Drives straight with a fixed throttle: half throttle (1.5 m/s2) reaches the top speed (8.33 m/s) after 5.6 s."""

    throttle: float = eqx.field(static=True, default=0.5)
    """Share of the largest acceleration, in [-1, 1]."""
    view: View = eqx.field(static=True, default=Observation("driver", "paper"))
    """What it sees (it uses nothing)."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(self, key: Key[Array, "*batch"], memory: None, observation: Features) -> tuple[Action, None]:
        """Return the fixed action."""
        batch = observation.shape[1:]
        return _action(jnp.full(batch, self.throttle, jnp.float32), jnp.zeros(batch, jnp.float32)), memory


class RuleBased(eqx.Module):
    """Drives straight to the goal at full throttle: its steering angle is the goal's bearing, at most 0.52 rad.

    It observes neither lanes nor people. Where the road bends, it meets the kerb and slides along it.
    """

    max_steering: float = from_world("max_steering")
    """The car's largest steering angle [rad]."""
    view: View = eqx.field(static=True, default=Observation("driver", "paper"))
    """What it sees."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(self, key: Key[Array, "*batch"], memory: None, observation: Features) -> tuple[Action, None]:
        """Return full throttle and the steering that points to the goal."""
        steering = _steer_at_goal(observation, self.max_steering)
        return _action(jnp.full_like(steering, FULL_THROTTLE), steering), memory


class RuleBasedBraking(eqx.Module):
    """Drives like `RuleBased`, but brakes fully (3 m/s2) while a pedestrian is in a cone ahead.

    The cone reaches 13 m from the car's centre (from top speed the car stops in 11.6 m, and 1.5 m is a collision) and
    20 degrees to either side of its heading. The driver observes the six nearest pedestrians.
    """

    cone_range: float = eqx.field(static=True, default=13.0)
    """Length of the cone [m]."""
    cone_half_angle: float = eqx.field(static=True, default=20.0)
    """Largest bearing to either side [degrees]."""
    max_steering: float = from_world("max_steering")
    """The car's largest steering angle [rad]."""
    view: View = eqx.field(static=True, default=Observation("driver", "paper"))
    """What it sees."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(self, key: Key[Array, "*batch"], memory: None, observation: Features) -> tuple[Action, None]:
        """Return full throttle or full braking, and the steering that points to the goal."""
        blocked = _somebody_in_cone(observation, self.cone_range, self.cone_half_angle)
        throttle = jnp.where(blocked, FULL_BRAKING, FULL_THROTTLE)
        return _action(throttle, _steer_at_goal(observation, self.max_steering)), memory


class RouteFollower(eqx.Module):
    """Follows its lane route at full throttle, also through turns, and ignores people (pure pursuit, 2.5 m ahead)."""

    wheelbase: float = from_world("wheelbase")
    """Distance between the car's axles [m]."""
    max_steering: float = from_world("max_steering")
    """The car's largest steering angle [rad]."""
    point: int = eqx.field(static=True, default=0)
    """The point of the route to steer to: an index of ``jaxwalk.sim.map_tables.POINTS``."""
    view: View = eqx.field(static=True, default=Observation("driver", "route"))
    """What it sees."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(self, key: Key[Array, "*batch"], memory: None, observation: Features) -> tuple[Action, None]:
        """Return full throttle and the steering that follows the route."""
        route = observation[part("driver", "route", "route")]
        steering = pursue(route, point=self.point, wheelbase=self.wheelbase, max_steering=self.max_steering)
        return _action(jnp.full_like(steering, FULL_THROTTLE), steering), memory


class Careless(eqx.Module):
    """Drives like `RouteFollower`, but each environment's car has its own speed limit between 3 m/s and the top speed.

    Pedestrians learn to wait among cars of many speeds. No evaluation uses this driver.
    """

    follower: RouteFollower = eqx.field(default_factory=RouteFollower)
    """The driver that steers."""
    slowest: float = eqx.field(static=True, default=3.0)
    """The lowest speed limit [m/s]."""
    fastest: float = eqx.field(static=True, default=SimConfig.max_speed)
    """The highest one [m/s]."""

    @property
    def view(self) -> View:
        """What it sees."""
        return self.follower.view

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Float[Array, "*batch"]:
        """Return each car's speed limit [m/s], spread evenly over any range of environments (golden ratio)."""
        share = (jnp.arange(math.prod(batch)) * 0.618034) % 1
        return (self.slowest + share * (self.fastest - self.slowest)).reshape(batch)

    def act(
        self, key: Key[Array, "*batch"], memory: Float[Array, "*batch"], observation: Features
    ) -> tuple[Action, Float[Array, "*batch"]]:
        """Return full throttle up to the speed limit, and the follower's steering."""
        (_, steering), _ = self.follower.act(key, None, observation)
        (speed,) = observation[part("driver", "route", "speed")] * SPEED
        return _action(jnp.where(speed < memory, FULL_THROTTLE, 0.0), steering), memory


DRIVERS: dict[str, Callable[[], Policy]] = {
    "random": Random,
    "constant-speed": ConstantSpeed,
    "rule-based": RuleBased,
    "rule-based-braking": RuleBasedBraking,
    "route-follower": RouteFollower,
    "clearance": ClearanceRule,
    "cautious": CautiousRule,
    "careful-human": CarefulHuman,
    "careful-human-aeb": careful_human_with_aeb,
    "fuzzy-safety": FuzzySafety,
    "crosswalk-yield": CrosswalkYield,
    "idm-yield": IdmYield,
    "belief-planner": BeliefPlanner,
    "belief-planner-chance": chance_planner,
    "belief-planner-cvar": cvar_planner,
    "oracle": Oracle,
}
"""Rule-based drivers by name: call an entry to make the driver."""


def _action(acceleration: Array, steering: Array) -> Action:
    return jnp.stack([acceleration, steering])


def _steer_at_goal(observation: Features, max_steering: float) -> Float[Array, "*batch"]:
    """Return the steering to the goal that the observation set "paper" shows, as a share of the largest angle."""
    ahead, left = observation[part("driver", "paper", "goal")]
    return jnp.clip(jnp.arctan2(left, ahead) / max_steering, -1, 1)


def _somebody_in_cone(observation: Features, length: float, half_angle: float) -> Bool[Array, "*batch"]:
    """Return whether a pedestrian in the set "paper" is within ``length`` [m] and ``half_angle`` [degrees]."""
    people = observation[part("driver", "paper", "people")]
    ahead, left = jnp.moveaxis(people.reshape(NEIGHBOURS, 4, *people.shape[1:])[:, :2], 1, 0) * DISTANCE
    away = jnp.sqrt(ahead * ahead + left * left)
    inside = (away <= length) & (ahead >= away * math.cos(math.radians(half_angle)))
    return inside.any(axis=0)
