"""What a driver believes that people may do: futures with their probabilities.

In each future somebody crosses the car's way, a strip along its route, in one interval of time. A person has as many
futures as the planner wants; people decide independently of each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.policies.planner_scene import HiddenPlaces, PeopleAhead
from jaxwalk.sim.corridor import NEARING
from jaxwalk.sim.events import distance
from jaxwalk.sim.person_kind import PersonKind
from jaxwalk.sim.what_if import SETTING_OUT, WALKING

NEVER = 1e3
"""What never happens happens this much later [s]."""


class WalkOn(NamedTuple):
    """People who keep their velocity; arrays ``(person, *batch)``."""

    weight: Float[Array, "person *batch"]
    """Probability."""
    along: Float[Array, "person *batch"]
    """Way along the route from the car's centre [m]."""
    along_speed: Float[Array, "person *batch"]
    """Speed along the route [m/s]."""
    enters: Float[Array, "person *batch"]
    """When they come into the car's way [s]."""
    leaves: Float[Array, "person *batch"]
    """When they leave it [s]; before they enter if they don't come into it."""


class StepOut(NamedTuple):
    """People who turn to the car's way at a moment, and walk straight across; arrays ``(future, *batch)``."""

    weight: Float[Array, "future *batch"]
    """Probability."""
    along: Float[Array, "future *batch"]
    """Where on the route they cross, from the car's centre [m]."""
    seen: Float[Array, "future *batch"]
    """When the car sees that they come [s]."""
    enters: Float[Array, "future *batch"]
    """When they come into the car's way [s]."""
    leaves: Float[Array, "future *batch"]
    """When they leave it [s]."""


class PeopleBelief(eqx.Module):
    """What a driver takes people for: the numbers from which their futures follow."""

    futures: int = eqx.field(static=True, default=16)
    """Moments of stepping out, times paces, that are told apart for each person (K)."""
    within: float = eqx.field(static=True, default=4.0)
    """It thinks of who steps out within this time [s]."""
    hazard: float = eqx.field(static=True, default=0.0)
    """Rate at which people beside the roadway step out, if their next crossing is a jaywalk [1/s]."""
    takes_crosswalk: float = eqx.field(static=True, default=0.2)
    """Probability that somebody who walks to a crosswalk over the route takes it."""
    emergence: float = eqx.field(static=True, default=0.0)
    """Rate at which people step out of a metre of hidden kerb, if their next crossing is a jaywalk [1/(m s)]."""
    seen_at: float = eqx.field(static=True, default=0.8)
    """Who was hidden comes into sight this far beside the car's way [m]."""

    def walk_on(self, people: PeopleAhead, beside: float) -> WalkOn:
        """Return the future in which everybody keeps their velocity.

        Args:
            people: who is ahead.
            beside: the car's way reaches this far to either side of the route [m].
        """
        still, inside = jnp.abs(people.left_speed) < WALKING, jnp.abs(people.left) < beside
        speed = jnp.where(still, 1, people.left_speed)
        one, other = (-beside - people.left) / speed, (beside - people.left) / speed
        enters = jnp.where(still, jnp.where(inside, 0, NEVER), jnp.maximum(jnp.minimum(one, other), 0))
        leaves = jnp.where(still, jnp.where(inside, NEVER, 0), jnp.maximum(one, other))
        weight = (1 - self._takes(people)) * jnp.exp(-self._rate(people) * self.within)
        return WalkOn(weight, people.along, people.along_speed, enters, leaves)

    def step_out(
        self, people: PeopleAhead, places: HiddenPlaces | None, beside: float, kinds: Sequence[PersonKind]
    ) -> StepOut:
        """Return the futures in which somebody takes a crosswalk or jaywalks, or comes out of a hidden place."""
        running = dashes(kinds)
        found = [self._crosswalk(people, beside)]
        if self.hazard > 0:
            found.append(self._jaywalk(people, beside, running))
        if places is not None and self.emergence > 0:
            found.append(self._emerge(places, beside, running))
        return jax.tree.map(lambda *columns: jnp.concatenate(columns), *found)

    def _takes(self, people: PeopleAhead) -> Float[Array, "person *batch"]:
        """Return the probability that people take a crosswalk."""
        leaves = -jnp.sign(people.left) * people.left_speed < -WALKING
        nears = ~people.on_roadway & ~leaves & (people.to_crosswalk < NEARING)
        return self.takes_crosswalk * (1 - people.jaywalks) * nears

    def _rate(self, people: PeopleAhead) -> Float[Array, "person *batch"]:
        """Return the rate at which people step out [1/s]."""
        return self.hazard * people.jaywalks * ~people.on_roadway

    def _crosswalk(self, people: PeopleAhead, beside: float) -> StepOut:
        """Return the futures of people who go on to a crosswalk, and take it at their pace."""
        pace = _pace(people)
        seen = people.to_crosswalk / pace
        enters = seen + jnp.maximum(jnp.abs(people.left) - beside, 0) / pace
        along = people.along + people.along_speed * seen
        return StepOut(self._takes(people), along, seen, enters, enters + 2 * beside / pace)

    def _jaywalk(self, people: PeopleAhead, beside: float, running: Sequence[float]) -> StepOut:
        """Return the futures of people who turn to the car's way at some moment."""
        time, step, dash = self._moments(people.along.ndim, running)
        rate = self._rate(people)
        weight = (jnp.exp(-rate * (time - step / 2)) - jnp.exp(-rate * (time + step / 2))) / len(running)
        way = jnp.maximum(jnp.abs(people.left + people.left_speed * time) - beside, 0)
        way = jnp.where(people.lost, jnp.minimum(way, self.seen_at), way)
        along = people.along + people.along_speed * time
        pace = jnp.maximum(_pace(people), dash)
        return _flat((1 - self._takes(people)) * weight, along, time, time + way / pace, 2 * beside / pace)

    def _emerge(self, places: HiddenPlaces, beside: float, running: Sequence[float]) -> StepOut:
        """Return the futures of people who may be hidden."""
        time, step, dash = self._moments(places.along.ndim, running)
        weight = self.emergence * places.expected * step / len(running)
        way = jnp.clip(places.away - beside, 0, self.seen_at)
        pace = jnp.maximum(SETTING_OUT, dash)
        return _flat(weight, places.along, time, time + way / pace, 2 * beside / pace)

    def _moments(self, axes: int, running: Sequence[float]) -> tuple[Array, float, Array]:
        """Return the middles of the moments [s], how long each is, and the paces; ``(moment, pace, *one)``."""
        count = max(self.futures // len(running), 1)
        step = self.within / count
        time = (step * (jnp.arange(count) + 0.5)).reshape(-1, *(1,) * (1 + axes))
        return time, step, jnp.array(running).reshape(-1, *(1,) * axes)


def dashes(kinds: Sequence[PersonKind]) -> tuple[float, ...]:
    """Return at which speeds people may jaywalk [m/s]: quartiles of the kind that does so most; else at their pace."""
    kind = max(kinds, key=lambda one: one.share * one.tendency, default=None)
    if kind is None or kind.jaywalk is None:
        return (0.0,)
    slowest, fastest = kind.jaywalk
    return tuple(slowest + share * (fastest - slowest) for share in (0.25, 0.75))


def _pace(people: PeopleAhead) -> Float[Array, "person *batch"]:
    """Return how fast people walk [m/s], or would if they set out."""
    speed = distance(people.along_speed, people.left_speed)
    return jnp.where(speed > WALKING, speed, SETTING_OUT)


def _flat(weight: Array, along: Array, seen: Array, enters: Array, crossing: Array) -> StepOut:
    """Return arrays ``(moment, pace, person, *batch)`` as futures; ``crossing`` is how long a crossing takes [s]."""
    columns = jnp.broadcast_arrays(weight, along, seen, enters, enters + crossing)
    return StepOut(*(column.reshape(-1, *column.shape[3:]) for column in columns))
