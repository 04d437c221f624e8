"""Our own parts pass the contracts that ship, and whatever breaks one is told in words."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.interfaces import Box, Discrete, Moment, Outcome, RoleSpec
from jaxwalk.metrics import METRICS, Metric
from jaxwalk.policies import DRIVERS, POPULATIONS, Random, RouteFollower, load_policy, shipped_policy
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.testing import (
    ContractError,
    check_driver,
    check_environment,
    check_metric,
    check_pedestrians,
    check_policy,
)
from metrics.scenes import ghosts_of, random_trajectory

FEW = 3


@pytest.fixture(scope="module")
def small():
    return Street.create(config=SimConfig(horizon=2, pedestrians=3))


@dataclass(frozen=True)
class Place:
    agents: tuple[int, ...] = ()
    name: str = "place"

    def __call__(self, moment):
        return jnp.broadcast_to(moment.state, (1, *self.agents, *moment.state.shape[-1:]))


@dataclass(frozen=True)
class Line:
    """A walker and two dogs on a line; ``broken`` names what is wrong with it."""

    broken: str = ""

    @property
    def roles(self):
        return {"walker": RoleSpec((), Box(1)), "dog": RoleSpec((2,), Discrete(3))}

    def draw(self, key):
        return jax.random.uniform(key)

    def reset(self, scenario):
        if self.broken == "weak":
            return jnp.full(scenario.shape, 0.5)
        return scenario[..., None] if self.broken == "batch" else scenario * 1.0

    def view(self, role, name):
        if name != "place" and self.broken != "view":
            raise ValueError(f"no view {name}")
        return Place(self.roles[role].agents if self.broken != "observe" else (5,))

    def observe(self, scenario, state, view):
        return view(Moment(self, scenario, state))

    def unhidden(self, scenario, state):
        return state / 0.0 if self.broken == "unhidden" else state

    def global_state(self, scenario, state):
        return state[None] / (0.0 if self.broken == "global" else 1.0)

    def step(self, scenario, state, actions):
        after = state + (jnp.cumsum(actions["walker"][0]) if self.broken == "alone" else actions["walker"][0])
        after = after.astype(jnp.float16) if self.broken == "types" else after
        over = after > 1
        dogs = jnp.broadcast_to(over, (2, *over.shape))
        terminated = {"walker": over, "dog": dogs & (self.broken != "ended")}
        truncated = {"walker": over & (self.broken == "both"), "dog": dogs & False}
        rewards: Any = {
            "walker": {"pay": after * 1.0},
            "dog": {"pay": dogs[0] * 1.0 if self.broken == "pay" else dogs * 1.0},
        }
        return after, Outcome(rewards, terminated, truncated, over, None, self.costs(after))

    def costs(self, after: Any) -> Any:
        """What each broken one charges; the sound one charges the walker for its place."""
        return {
            "cost": {"dog": {"noise": jnp.abs(after)}},
            "negative cost": {"walker": {"place": -1.0 - jnp.abs(after)}},
            "whose cost": {"cat": {"place": jnp.abs(after)}},
            "no cost": {},
        }.get(self.broken, {"walker": {"place": jnp.abs(after) * 1.0}})


class Sleepy(eqx.Module):
    """Does nothing, but for what ``broken`` names."""

    broken: str = eqx.field(static=True, default="")
    view: Any = eqx.field(static=True, default=Place())

    def init(self, agents, batch):
        return jnp.zeros((*agents, *batch))

    def act(self, key, memory, seen):
        action = {
            "size": jnp.zeros((2, *memory.shape)),
            "range": jnp.full((1, *memory.shape), 2.0),
            "finite": jnp.full((1, *memory.shape), jnp.nan),
            "kind": jnp.zeros((1, *memory.shape), int),
            "neighbours": jnp.zeros((1, *memory.shape)) + jnp.arange(memory.size) / 9,
            "chance": jnp.full((1, *memory.shape), np.random.default_rng().uniform()),
        }.get(self.broken, jnp.zeros((1, *memory.shape)))
        return action, memory.astype(int) if self.broken == "memory" else memory


VIEWS = {"driver": ["route", "paper"], "pedestrian": ["kerb"]}


@pytest.mark.long
def test_our_street_passes(small):
    check_environment(small, VIEWS, steps=FEW)


def test_our_street_with_hidden_people_passes():
    street = Street.create(config=SimConfig(horizon=2, pedestrians=3, perception=True, sight=20.0))
    check_environment(street, VIEWS, steps=FEW)


def test_our_policies_pass(small):
    for driver in (RouteFollower(), Random(), load_policy(shipped_policy("driver", "co-trained"), "driver")):
        check_driver(driver, small, steps=FEW)
    people = load_policy(shipped_policy("pedestrian", "learned"), "pedestrian", sample=True)
    check_pedestrians(people, small, steps=FEW)


@pytest.mark.long
@pytest.mark.parametrize("name", DRIVERS)
def test_our_rules_pass(small, name):
    check_driver(DRIVERS[name](), small, steps=FEW)


@pytest.mark.parametrize("name", POPULATIONS)
def test_our_people_pass(small, name):
    check_pedestrians(POPULATIONS[name](), small, steps=FEW)


@pytest.fixture(scope="module")
def recorded():
    found = random_trajectory(0, episodes=4, frames=30, people=3)
    return found, ghosts_of(found)


@pytest.mark.parametrize("metric", METRICS, ids=lambda metric: metric.name)
def test_our_metrics_pass(recorded, metric):
    check_metric(metric, *recorded)


@dataclass(frozen=True)
class Lengths:
    steps: np.ndarray


@dataclass(frozen=True)
class Length:
    longest: float


def _longest(rows, sums) -> Length:
    return Length(rows.values(lambda chunk: chunk[LENGTH].steps).ends()[1])


def _at_once(rows, sums) -> Length:
    return Length(float(rows[LENGTH].steps.max()))


def _nothing(rows, sums) -> Length:
    return Length(float("nan"))


def _word(rows, sums) -> Length:
    return Length("long")  # pyright: ignore


LENGTH = Metric(name="length", measure=lambda r: Lengths(r.trajectory.length), summarise=_longest)


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        ({"summarise": _nothing}, "length: its numbers must be plain JSON, None where there is none"),
        ({"summarise": _at_once}, "length: summarise must read rows by `Rows.total`"),
        ({"summarise": _word}, "length: its numbers must have the types that it declares"),
        ({"columns": lambda rows: {"one": np.ones(2)}}, "column one must have a row for each of 4 episodes, not 2"),
        ({"measure": lambda r: Lengths(np.random.default_rng().uniform(size=4))}, "measure must be deterministic"),
    ],
)
def test_a_broken_metric_is_told_what_it_breaks(recorded, broken, message):
    check_metric(LENGTH, *recorded)
    with pytest.raises(ContractError, match=message):
        check_metric(replace(LENGTH, **broken), *recorded)


def test_a_sound_environment_and_policy_pass():
    for sound in ("", "no cost"):
        check_environment(Line(sound), {"walker": ["place"], "dog": ["place"]})
    check_policy(Sleepy(), Line(), "walker")


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        ("batch", r"reset:  has shape \(4, 1\); arrays must end in the batch axis"),
        ("weak", "reset: the state has no type of its own; give it one, such as jnp.full"),
        ("view", "view: it must raise ValueError for a name that there isn't"),
        ("observe", r"observe: walker place has shape \(1, 5, 4\)"),
        ("unhidden", "unhidden, observe: walker place has a number that isn't finite"),
        ("global", "global_state: it has a number that isn't finite"),
        ("alone", "step: an episode must come out the same alone as in a batch"),
        ("types", "step: it must keep the state's structure, shapes and types"),
        ("ended", "ended: an episode ends for everybody at once, but not for dog"),
        ("both", "an agent of walker is both at once"),
        ("pay", r"rewards: dog pay has shape \(4,\); it must be \(2, 4\)"),
        ("cost", r"costs: dog noise has shape \(4,\); it must be \(2, 4\)"),
        ("negative cost", "costs: walker place must be finite numbers of 0 or more"),
        ("whose cost", "costs: it must have roles of walker, dog only"),
    ],
)
def test_a_broken_environment_is_told_what_it_breaks(broken, message):
    with pytest.raises(ContractError, match=message):
        check_environment(Line(broken), {"walker": ["place"], "dog": ["place"]}, steps=12)


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        ("size", r"act: the walker's action has shape \(2, 4\); it must be \(1, 4\): a number in \[-1, 1\] each"),
        ("range", r"act: the walker's action must be a number in \[-1, 1\], but some are in \[2, 2\]"),
        ("finite", "act: the walker's action has a number that isn't finite"),
        ("kind", "act: the walker's action is int32; it must be floats"),
        ("neighbours", "act: an episode's action must be the same alone as in a batch"),
        ("chance", "act: equal keys, memories and views must give equal actions"),
        ("memory", "act: the memory must keep its structure, shapes and types"),
    ],
)
def test_a_broken_policy_is_told_what_it_breaks(broken, message):
    with pytest.raises(ContractError, match=message):
        check_policy(Sleepy(broken), Line(), "walker")


def test_a_view_must_be_hashable_and_have_a_name():
    class Loose(Place):
        __hash__ = None

    with pytest.raises(ContractError, match="view: place must be hashable"):
        check_policy(Sleepy(view=Loose()), Line(), "walker")
    with pytest.raises(ContractError, match="view: it must have a name"):
        check_policy(Sleepy(view=Place(name="")), Line(), "walker")
