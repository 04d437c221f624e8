"""What a car is told, or can infer, of people's intent: of the nearest ones that it perceives, nearest first."""

from __future__ import annotations

from collections.abc import Sequence

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import belief
from jaxwalk.sim.crossing_kind import JAYWALK, LegKind
from jaxwalk.sim.features import FLAG, PURE, Bound, Feature, Limits, both, share
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.jaywalk import line_of
from jaxwalk.sim.prediction import DISTANCE, NEIGHBOURS, of_nearest


def _tendencies(moment: Moment, tendency: Float[Array, "ped *batch"]) -> Sequence[Array]:
    """Return the tendencies of the nearest people; the prior mean for neighbours who aren't there."""
    prior = belief.prior_mean(moment.world)
    unknown = jnp.full((NEIGHBOURS, *moment.state.step.shape), prior)
    if moment.state.perceived is not None:
        tendency = jnp.where(moment.state.perceived.now.seen, tendency, prior)
    return (of_nearest(moment.state.foresight.people, tendency, unknown),)


def _expected_tendencies(moment: Moment) -> Sequence[Array]:
    world, scenario, state = moment.world, moment.scenario, moment.state
    if state.perceived is None:
        return _tendencies(moment, belief.expected_tendency(world, scenario, state.pedestrian))
    seen = state.perceived.crossings
    return _tendencies(moment, belief.expected_after(world, scenario, seen.jaywalks, seen.crosswalks))


def _decisions(moment: Moment) -> Sequence[Array]:
    """Return three numbers for each of the nearest people: 1 if it has decided to jaywalk, and where it will step out.

    The place is in the car's frame. For somebody who is on the way across already it is where they are; for those who
    haven't decided to jaywalk it is far ahead.
    """
    world, scenario, car, people = moment.world, moment.scenario, moment.state.vehicle, moment.state.pedestrian
    across = people.leg.kind == LegKind.ACROSS
    x, y = line_of(world, scenario, people.leg.side)(people.leg.begin).at(people.leg.begin)
    x, y = jnp.where(across, people.x, x), jnp.where(across, people.y, y)
    ahead, left = to_frame(x - car.x[None], y - car.y[None], car.cos[None], car.sin[None])
    decided = people.crossing == JAYWALK
    if moment.state.perceived is not None:
        decided &= moment.state.perceived.now.seen
    told = (
        decided.astype(ahead.dtype),
        jnp.where(decided, ahead / DISTANCE, 1),
        jnp.where(decided, left / DISTANCE, 0),
    )
    unknown = tuple(jnp.full((NEIGHBOURS, *car.x.shape), value) for value in (0.0, 1.0, 0.0))
    rows = jnp.stack(of_nearest(moment.state.foresight.people, told, unknown), axis=1)
    return (rows.reshape(-1, *car.x.shape),)


def _decisions_bounds(limits: Limits) -> Sequence[Bound]:
    place = both(max(limits.diagonal, DISTANCE) / DISTANCE)
    return [(0.0, 1.0), place, place]


TOLD_TENDENCIES = Feature(
    "tendencies", NEIGHBOURS, share, lambda m: _tendencies(m, m.scenario.jaywalking_tendency(m.world)), PURE
)
"""The jaywalking tendency of each of the nearest people."""
PLACEBO = Feature("tendencies", NEIGHBOURS, share, lambda m: _tendencies(m, m.scenario.traits[2]), PURE)
"""A trait of each of the nearest people that decides nothing."""
EXPECTED_TENDENCIES = Feature("tendencies", NEIGHBOURS, share, _expected_tendencies, PURE)
"""The posterior mean of the jaywalking tendency of each of the nearest people."""
TOLD_DECISIONS = Feature(
    "decisions", 3 * NEIGHBOURS, _decisions_bounds, _decisions, (*FLAG, f"{DISTANCE:g} m", f"{DISTANCE:g} m")
)
"""Who of the nearest people has decided to jaywalk, and where."""
