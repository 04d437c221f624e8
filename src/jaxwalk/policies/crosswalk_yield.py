"""The crosswalk rule of a deployed driving stack: yield to who walks over, or may."""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.policies.corridor_driver import STANDING, Ahead, CorridorDriver, hold_emergency
from jaxwalk.safety.idm import FollowingStyle, idm_acceleration
from jaxwalk.safety.stopping import last_moment
from jaxwalk.sim.corridor import NEARING

SLOWEST = 0.1
"""Top speeds count as at least this [m/s]."""


class Patience(NamedTuple):
    """The driver's memory; arrays ``(*batch)``."""

    stops: Float[Array, "*batch"]
    """1 while it yields to somebody."""
    waited: Float[Array, "*batch"]
    """Time for which the car has stood and nobody at the crosswalk has moved [s]."""
    emergency: Float[Array, "*batch"]
    """1 while the automatic emergency braking brakes."""


class CrosswalkYield(CorridorDriver):
    """Stops before crosswalks for who is on them or may walk over, unless one of both is past long before the other.

    The rule and its numbers are those of Autoware's crosswalk module (behavior_velocity_crosswalk_module of
    github.com/autowarefoundation/autoware_universe). The car drives on if its time to the crossing of both ways
    plus 4 s is less than the person's, or the person's plus 13 s less than the car's, 0.5 s more once it yields; it
    takes itself for no slower than 2.0 m/s and people for no slower than 1.39 m/s. It stops 3.5 m before, unless a
    stop just before the crossing needs more than 1.5 m/s2, and sets out again when nobody there has moved (0.25
    m/s) for 1.0 s. The Intelligent Driver Model makes the stop, with the rule's preferred 1.0 m/s2 as its
    comfortable braking.

    Ours: who may walk over (`jaxwalk.sim.corridor.way_to_crosswalk`); that a stop that has begun isn't given up;
    and 1.0 s for everybody, which Autoware lessens to none 5 m from the crosswalk. Its slowing down for hidden
    places is left out. Beside the rule, automatic emergency braking brakes fully for whoever is on course, 0.4 s
    before the last moment that suffices: ours too, and all that this driver does about jaywalkers.
    """

    pass_first: float = eqx.field(static=True, default=4.0)
    """The car goes first if it is there this much earlier [s]."""
    pass_later: float = eqx.field(static=True, default=13.0)
    """The person is no hindrance if it is there this much earlier [s]."""
    chatter: float = eqx.field(static=True, default=0.5)
    """What both need more once the car yields [s]."""
    slowest_car: float = eqx.field(static=True, default=2.0)
    """The car is taken to be at least this fast [m/s]."""
    slowest_person: float = eqx.field(static=True, default=1.39)
    """People are taken to be at least this fast [m/s]."""
    still: float = eqx.field(static=True, default=0.25)
    """Who is slower than this doesn't move [m/s]."""
    patience: float = eqx.field(static=True, default=1.0)
    """After standing for this long before people who don't move, the car sets out [s]."""
    stop_before: float = eqx.field(static=True, default=3.5)
    """The car stops this far before the person's way [m]."""
    hardest: float = eqx.field(static=True, default=1.5)
    """A stop doesn't begin that would need a harder braking to end just before the person's way [m/s2]."""
    style: FollowingStyle = eqx.field(static=True, default=FollowingStyle(braking=1.0))
    """How it drives and stops."""
    spare: float = eqx.field(static=True, default=0.4)
    """The emergency braking begins this much before the last moment that suffices [s]: ours."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Patience:
        """Return the memory of a driver who yields to nobody."""
        nothing = jnp.zeros((*agents, *batch))
        return Patience(nothing, nothing, nothing)

    def act(
        self, key: Key[Array, "*batch"], memory: Patience, observation: Float[Array, "feature *batch"]
    ) -> tuple[Float[Array, "2 *batch"], Patience]:
        """Return the acceleration of driving or stopping, or full braking, and the steering along the route."""
        ahead = self.look(observation)
        gap, hinders = self._hinders(ahead, memory)
        moves = (jnp.abs(ahead.approach) > self.still) | (jnp.abs(ahead.along_speed) > self.still)
        stands, moved = ahead.speed < STANDING, (hinders & moves).any(axis=0)
        waits = hinders.any(axis=0) & ~moved & (stands | (memory.waited >= self.patience))
        waited = jnp.where(waits, memory.waited + self.dt, 0.0)
        yields = hinders & (waited < self.patience)
        to_leader = jnp.where(yields, gap - self.stop_before + self.style.standstill, jnp.inf)
        top, closing = jnp.maximum(ahead.top, SLOWEST), jnp.broadcast_to(ahead.speed, gap.shape)
        acceleration = idm_acceleration(ahead.speed, top, to_leader, closing, self.style).min(axis=0)
        late = ahead.time_to_collision() < last_moment(ahead.speed, self.max_braking, self.spare)
        emergency = hold_emergency(memory.emergency, ahead, late)
        acceleration = jnp.where(emergency > 0, -self.max_braking, acceleration)
        stops = yields.any(axis=0).astype(jnp.float32)
        return self.act_with(acceleration, observation), Patience(stops, waited, emergency)

    def _hinders(self, ahead: Ahead, memory: Patience) -> tuple[Array, Bool[Array, "person *batch"]]:
        """Return the gap to where each person's way crosses the car's [m], and whether the car must stop for them."""
        pace = jnp.sqrt(ahead.approach**2 + ahead.along_speed**2)
        share = ahead.to_crosswalk / jnp.maximum(pace, self.still)
        gap, aside = ahead.gap + share * ahead.along_speed, ahead.aside - share * ahead.approach
        leaves = (ahead.to_crosswalk <= 0) & (aside > 0) & (ahead.approach < -self.still)
        uses = (ahead.to_crosswalk < NEARING) & ~leaves & (gap > 0)
        car = gap / jnp.maximum(ahead.speed, self.slowest_car)
        person = (ahead.to_crosswalk + jnp.maximum(aside, 0)) / jnp.maximum(pace, self.slowest_person)
        more = self.chatter * memory.stops
        harmless = (car + self.pass_first + more < person) | (person + self.pass_later + more < car)
        needed = ahead.speed**2 / (2 * jnp.maximum(gap, 1e-3))
        return gap, uses & ~harmless & ((memory.stops > 0) | (needed <= self.hardest))
