"""People who all go while the car stands: their scenarios, and every step of them."""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from jaxwalk.rollout import draw_batch
from jaxwalk.sim import pedestrian


class Walked(NamedTuple):
    """What people did; arrays ``(step, ped, episode)``."""

    x: jax.Array
    y: jax.Array
    speed: jax.Array
    leg: jax.Array
    """The kind of leg."""
    decisions: jax.Array
    crossing: jax.Array
    arrivals: jax.Array


@eqx.filter_jit
def drawn(street, batch):
    return draw_batch(street, jax.random.split(jax.random.key(77), batch))


@eqx.filter_jit
def walked(street, scenarios) -> Walked:
    """Every step until the horizon."""

    def step(people, _):
        people = pedestrian.walk(street.world, scenarios, people, jnp.ones(people.going.shape, bool))
        speed = jnp.hypot(*pedestrian.velocity(street.world, scenarios, people))
        return people, Walked(
            people.x, people.y, speed, people.leg.kind, people.decisions, people.crossing, people.arrivals
        )

    return jax.lax.scan(step, pedestrian.place(street.world, scenarios), None, length=street.world.rules.horizon)[1]
