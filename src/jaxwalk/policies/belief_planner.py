"""The belief planner: plans its speed on what people may do, and minimises the expected cost.

The costs are those of Bai, Cai, Ye, Hsu and Lee (ICRA 2015). They solve a POMDP; this driver compares open-loop plans.
"""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.people_futures import PeopleBelief, StepOut, WalkOn
from jaxwalk.policies.planner_scene import ForPlanning, PlannerScene
from jaxwalk.policies.pursuit import pursue
from jaxwalk.policies.speed_plans import PLANS, SpeedPlans, speed_plans
from jaxwalk.policies.world_numbers import from_world
from jaxwalk.sim.everybody import for_everybody
from jaxwalk.sim.person_kind import PersonKind
from jaxwalk.sim.sim_config import ContactRule

RATE = 3
"""Decisions of the source in a second: costs are those of a step of 1 / 3 s."""
SLOWEST = 0.1
"""Top speeds count as at least this [m/s]."""
SAME = 1e-3
"""A change of speed is more than this [m/s]."""
EXCLUDED = 1e9
"""The cost of a plan that isn't allowed; the least dangerous is taken if none is."""
IMPACTS = (1.0, 3.0, 6.0, 10.0)
"""The quantile of the costs is looked for among no contact, and contacts at these speeds [m/s]."""

Memory = tuple[Float[Array, "*batch"], Int[Array, "*batch"]]
"""The pedal, as a share, and the number of steps for which it is still held."""


class BeliefPlanner(eqx.Module):
    """Takes the plan of speed whose cost, in the mean over the futures of the people that it knows of, is least.

    A plan is one acceleration for a while, then another one (`jaxwalk.policies.speed_plans`). What people may do is a
    `jaxwalk.policies.people_futures.PeopleBelief`. Who steps out makes the car brake fully, ``reaction`` later; else
    a plan is driven to its end, so nothing is gained by waiting to learn more. Each person's contact counts as if
    nobody else were there. The car steers by pure pursuit.
    """

    belief: PeopleBelief = eqx.field(default_factory=PeopleBelief)
    """What it takes people for."""
    contact_cost: float = eqx.field(static=True, default=1.0)
    """Cost of a contact at v m/s: this times (v2 + ``standing``)."""
    standing: float = eqx.field(static=True, default=30.0)
    """What a contact costs beside the square of its speed [m2/s2]."""
    slow_cost: float = eqx.field(static=True, default=0.5)
    """Cost of a step in which the car stands; less in proportion when it drives."""
    change_cost: float = eqx.field(static=True, default=0.1)
    """Cost of a step in which the speed changes."""
    discount: float = eqx.field(static=True, default=0.95)
    """What a cost one step later counts."""
    lookahead: float = eqx.field(static=True, default=5.0)
    """Plans are driven for this time [s]; then the car drives on at full throttle, among nobody."""
    reaction: float = eqx.field(static=True, default=0.2)
    """The car brakes this long after it sees somebody step out [s]."""
    room_aside: float = eqx.field(static=True, default=0.1)
    """Room that it wants between the car's side and a body [m]."""
    room_ahead: float = eqx.field(static=True, default=0.3)
    """Room that it wants before and behind the car [m]."""
    tolerated: float = eqx.field(static=True, default=1.0)
    """Plans with more contacts of the moving car than this, in the mean, are excluded; 1: none is."""
    tail: float = eqx.field(static=True, default=0.0)
    """The mean is that of the worst futures, with a probability of 1 - ``tail`` (conditional value at risk)."""
    held: int = eqx.field(static=True, default=1)
    """Steps from one decision to the next."""
    max_acceleration: float = from_world("max_acceleration")
    """The car's largest acceleration [m/s2]."""
    max_braking: float = from_world("max_braking")
    """Its largest braking [m/s2]."""
    max_steering: float = from_world("max_steering")
    """Its largest steering angle [rad]."""
    wheelbase: float = from_world("wheelbase")
    """Distance between its axles [m]."""
    car_length: float = from_world("car_length")
    """Its length [m]."""
    car_width: float = from_world("car_width")
    """Its width [m]."""
    body_radius: float = from_world("body_radius")
    """Radius of a pedestrian's body [m]."""
    collision_distance: float = from_world("collision_distance")
    """Centres closer than this collide, where contacts are by disc [m]."""
    contact: ContactRule = from_world("contact")
    """What counts as a contact."""
    moving_speed: float = from_world("moving_speed")
    """A car at this speed or more is moving when a contact happens [m/s]."""
    kinds: tuple[PersonKind, ...] = from_world("kinds")
    """Kinds of people that there are: how fast they jaywalk."""
    view: View = eqx.field(static=True, default=ForPlanning())
    """What it sees."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Memory:
        """Return a memory that holds nothing yet."""
        return jnp.zeros((*agents, *batch)), jnp.zeros((*agents, *batch), jnp.int32)

    def act(
        self, key: Key[Array, "*batch"], memory: Memory, seen: PlannerScene
    ) -> tuple[Float[Array, "2 *batch"], Memory]:
        """Hold the pedal, or plan anew; return pedal and steering."""
        pedal, left = memory
        planned = jax.lax.cond((left == 0).any(), lambda seen: self.best_pedal(seen), lambda _: pedal, seen)
        pedal = jnp.where(left == 0, planned, pedal)
        steering = pursue(seen.route, wheelbase=self.wheelbase, max_steering=self.max_steering)
        return jnp.stack([pedal, steering]), (pedal, jnp.where(left == 0, self.held, left) - 1)

    def best_pedal(self, seen: PlannerScene) -> Float[Array, "*batch"]:
        """Return what the best plan begins with, as a share of the largest acceleration or braking."""
        cost = self.judge(seen)
        return jnp.asarray(PLANS[:, 0], cost.dtype)[cost.argmin(axis=0)]

    def judge(self, seen: PlannerScene) -> Float[Array, "plan *batch"]:
        """Return the cost of each of the `jaxwalk.policies.speed_plans.PLANS`."""
        top = jnp.maximum(seen.top, SLOWEST)
        plans = speed_plans(seen.speed, top, self.max_acceleration, self.max_braking)
        _, aside = self._reach()
        walking = self.belief.walk_on(seen.people, aside)
        stepping = self.belief.step_out(seen.people, seen.places, aside, self.kinds)
        begin = self._nothing(plans)
        found = for_everybody(walking, lambda one, found: self._add(found, one.weight, *self.met(plans, one)), begin)
        found = for_everybody(
            stepping, lambda one, found: self._add(found, one.weight, *self.met_braking(plans, one)), found
        )
        return self._total(plans, *found)

    def met(self, plans: SpeedPlans, one: WalkOn) -> tuple[Array, Array, Array]:
        """Return whether each plan's car meets somebody who walks on, how fast it is then [m/s], and when [s]."""
        ahead, _ = self._reach()
        enters, leaves = one.enters, jnp.minimum(one.leaves, self.lookahead)
        before, _ = plans.at(enters)
        after, _ = plans.at(leaves)
        before, after = before - one.along - one.along_speed * enters, after - one.along - one.along_speed * leaves
        meets = (enters < leaves) & (before < ahead) & (after > -ahead)
        share = jnp.clip((-ahead - before) / jnp.maximum(after - before, SAME), 0, 1)
        when = enters + share * (leaves - enters)
        return meets, plans.at(when)[1], when

    def met_braking(self, plans: SpeedPlans, one: StepOut) -> tuple[Array, Array, Array]:
        """Return the same for who steps out, if the car brakes fully from ``reaction`` after it sees them."""
        ahead, _ = self._reach()
        begins = one.seen + self.reaction
        way, speed = plans.at(begins)

        def gap(time: Array) -> Array:
            braking = jnp.minimum(time - begins, speed / self.max_braking)
            return way + speed * braking - self.max_braking / 2 * jnp.maximum(braking, 0) ** 2 - one.along

        before, after = gap(one.enters), gap(one.leaves)
        meets = (one.enters < self.lookahead) & (before < ahead) & (after > -ahead)
        beside = speed - self.max_braking * jnp.maximum(one.enters - begins, 0)
        squared = speed**2 - 2 * self.max_braking * jnp.maximum(one.along - ahead - way, 0)
        impact = jnp.where(before > -ahead, beside, jnp.sqrt(jnp.maximum(squared, 0)))
        return meets, jnp.maximum(impact, 0), one.enters

    def contact_costs(self, speed: Float[Array, "..."], when: Float[Array, "..."]) -> Float[Array, "..."]:
        """Return the cost of a contact at a speed [m/s], at a time from now [s]."""
        return self.contact_cost * (speed**2 + self.standing) * self.discount ** (RATE * when)

    def way_costs(self, plans: SpeedPlans) -> Float[Array, "plan *batch"]:
        """Return the cost of each plan's speeds, and of the time until the car is at its top speed again."""
        steps = round(self.lookahead * RATE)
        number = jnp.arange(1, steps + 1).reshape(-1, *(1,) * plans.middle_way.ndim)
        _, speed = plans.at(number / RATE)
        before = jnp.concatenate([jnp.broadcast_to(plans.speed, speed[:1].shape), speed[:-1]])
        slow = self.slow_cost * jnp.maximum(plans.top - speed, 0) / plans.top
        changes = self.change_cost * (jnp.abs(speed - before) > SAME)
        lacking = jnp.maximum(plans.top - speed[-1], 0)
        regained = self.slow_cost * RATE * lacking**2 / (2 * self.max_acceleration * plans.top)
        return (self.discount**number * (slow + changes)).sum(axis=0) + self.discount**steps * regained

    def _reach(self) -> tuple[float, float]:
        """Return how near people may come to the car's centre along its way, and beside it [m]."""
        if self.contact == "disc":
            return self.collision_distance + self.room_ahead, self.collision_distance + self.room_aside
        ahead, aside = (x / 2 + self.body_radius for x in (self.car_length, self.car_width))
        return ahead + self.room_ahead, aside + self.room_aside

    def _quantiles(self) -> list[float]:
        """Return the costs among which the quantile is looked for."""
        return [0.0, *(self.contact_cost * (v**2 + self.standing) for v in IMPACTS if self.tail > 0)]

    def _nothing(self, plans: SpeedPlans) -> tuple[Array, Array]:
        """Return the mean costs above each quantile, and the mean number of contacts while moving, of nobody."""
        none = jnp.zeros(plans.middle_way.shape)
        return jnp.zeros((len(self._quantiles()), *none.shape)), none

    def _add(self, found: tuple[Array, Array], weight: Array, meets: Array, speed: Array, when: Array) -> tuple:
        """Return these means with one future more."""
        quantiles = jnp.array(self._quantiles()).reshape(-1, *(1,) * speed.ndim)
        cost = jnp.where(meets, weight, 0) * jnp.maximum(self.contact_costs(speed, when) - quantiles, 0)
        return found[0] + cost, found[1] + jnp.where(meets & (speed >= self.moving_speed), weight, 0)

    def _total(self, plans: SpeedPlans, above: Array, moving: Array) -> Float[Array, "plan *batch"]:
        """Return the cost of each plan (Rockafellar and Uryasev 2000 for the mean of the worst futures)."""
        quantiles = jnp.array(self._quantiles()).reshape(-1, *(1,) * moving.ndim)
        cost = self.way_costs(plans) + (quantiles + above / (1 - self.tail)).min(axis=0)
        return jnp.where(moving > self.tolerated, EXCLUDED * (1 + moving), cost) if self.tolerated < 1 else cost


def chance_planner() -> BeliefPlanner:
    """Return the planner that excludes plans with a probability of a contact while moving above 1 %."""
    return BeliefPlanner(tolerated=0.01)


def cvar_planner() -> BeliefPlanner:
    """Return the planner that minimises the mean cost of the worst 5 % of the futures."""
    return BeliefPlanner(tail=0.95)
