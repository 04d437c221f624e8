"""Ghosts: people of the same kind on the same streets, which the car can neither see nor touch.

A car's behaviour near ghosts shows what it would do there in any case: the placebo of the speed differential.
"""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Key

from jaxwalk.evaluation.playing import BLOCK
from jaxwalk.rollout import scenario_key
from jaxwalk.sim import pedestrian
from jaxwalk.sim.environment import Street
from jaxwalk.sim.recording import Frame, frame_of_people
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState
from jaxwalk.sim.trajectory import Ghosts, in_order


def walk_ghosts(street: Street, scenarios: Scenario, keys: Key[Array, "episode"], *, frames: int) -> Ghosts:
    """Return other people for every scenario's map and route, who always go: their first ``frames`` frames.

    Args:
        street: the world.
        scenarios: a batch, arrays ``(..., episode)``.
        keys: one key for each episode, as for `jaxwalk.evaluation.play`.
        frames: number of frames; at least 1.
    """
    others, people, first = _begin(street, scenarios, keys)
    blocks = [{name: np.asarray(x)[None] for name, x in first.items()}]
    for _ in range(1, frames, BLOCK):
        people, walked = _walk_block(street, others, people)
        blocks.append({name: np.asarray(x) for name, x in walked.items()})
    columns = {name: np.concatenate([block[name] for block in blocks])[:frames] for name in first}
    return Ghosts(**in_order(columns))


@eqx.filter_jit
def _begin(street: Street, scenarios: Scenario, keys: Key[Array, "episode"]) -> tuple[Scenario, PedestrianState, Frame]:
    """Return the ghosts' scenarios and first frame. Their keys are those of a second episode, which is never played."""
    second_episode = scenario_key(keys, jnp.ones(keys.shape, jnp.int32))
    others = jax.vmap(street.draw, in_axes=(0, -1), out_axes=-1)(second_episode, scenarios)
    people = pedestrian.place(street.world, others)
    return others, people, frame_of_people(street.world, others, people)


@eqx.filter_jit
def _walk_block(street: Street, others: Scenario, people: PedestrianState) -> tuple[PedestrianState, Frame]:
    """Return people after ``BLOCK`` steps, and the frames of the steps along a leading axis."""
    go = jnp.ones(people.going.shape, bool)

    def stride(people: PedestrianState, _: None) -> tuple[PedestrianState, Frame]:
        people = pedestrian.walk(street.world, others, people, go)
        return people, frame_of_people(street.world, others, people)

    return jax.lax.scan(stride, people, None, length=BLOCK)
