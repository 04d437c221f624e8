"""Ten million steps of random actions: no NaN, no infinity, and every observation within the bounds claimed for it.

    .venv/bin/python tests/reliability/random_steps.py

It prints what it saw, and exits with 1 if anything was wrong. Actions are held for a step, half a second or seconds,
mild or at their limits; people go sometimes, mostly or always; jaywalking goes from never to always.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk import Street
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.rollout import TRAINING, environment_keys, rollout, seed_key, start
from jaxwalk.sim.observation import OBSERVATIONS, PRIVILEGED, bounds
from jaxwalk.sim.reward import DRIVER_TERMS, PEDESTRIAN_TERMS

ENVIRONMENTS, STEPS = 1024, 16
"""Side by side; of each, before what was seen is added up and `PRIVILEGED`, 100 times as large, is looked at."""
MULTIPLIERS = (0.25, 0.0, 1.0, 4.0)
"""Of jaywalking, in turns."""
HELD = (1, 5, 20, 100)
"""For how many steps actions are held, in the mean; each environment has its own way, here and below."""
PUSH = (0.0, 0.3, 0.8)
"""What is added to throttles between -1 and 1 (and then held to these limits), so that cars get somewhere."""
EAGERNESS = (0.6, 0.95, 1.0, 0.3, 1.0)
"""How likely people are to go."""
SETS = [(role, name) for role, sets in OBSERVATIONS.items() for name in sets if name != PRIVILEGED]
ENDINGS = ("goal", "collision", "timeout")


def act(key, scenario, state, held):
    """Random actions, new ones now and then. The record is what there is to look at."""
    people = state.pedestrian.x.shape[0]

    def draw(one):
        renew, drive, go = jax.random.split(one, 3)
        return jax.random.uniform(renew), jax.random.uniform(drive, (2,), minval=-1), jax.random.uniform(go, (people,))

    renew, drive, go = jax.vmap(draw, out_axes=-1)(key)
    held_for, push, eagerness = (jnp.resize(jnp.array(x), key.shape) for x in (HELD, PUSH, EAGERNESS))
    new = {"driver": jnp.clip(drive.at[0].add(push), -1, 1), "pedestrian": (go < eagerness).astype(jnp.int32)}
    actions = jax.tree.map(lambda x, old: jnp.where(renew * held_for < 1, x, old), new, held)
    return actions, actions, (scenario, state)


def look(street, step):
    """The lowest and highest of everything in a step of all environments, by name; and how many steps and endings.

    A NaN or an infinity anywhere is in one of the two.
    """
    scenario, state = step.record
    seen = {f"{role} {name}": [street.observe(scenario, state, street.view(role, name))] for role, name in SETS}
    seen["global state"] = [street.global_state(scenario, state)]
    seen["state"] = [x[None] for x in jax.tree.leaves(eqx.tree_at(_kerbs, state, replace_fn=_or_nowhere))]
    seen["rewards"] = [x[None] for x in jax.tree.leaves(step.outcome.rewards)]
    limits = {name: jnp.concatenate([_limits(x) for x in arrays], axis=1) for name, arrays in seen.items()}
    endings = {name: jnp.sum(getattr(step.outcome.events, name) & step.valid) for name in ENDINGS}
    return limits, {"steps": jnp.sum(step.valid), **endings}


def _kerbs(state):
    """The only numbers that may be infinite: how far it is to the roadway, for whoever's path enters none."""
    return [state.pedestrian.leg.kerb_past_end, state.pedestrian.following.kerb_past_end]


def _or_nowhere(x):
    return jnp.where(x == jnp.inf, 0.0, x)


def _limits(x):
    """From ``(feature, ...)`` the lowest and the highest of each, ``(2, feature)``."""
    rows = x.reshape(x.shape[0], -1).astype(jnp.float32)
    return jnp.stack([rows.min(axis=1), rows.max(axis=1)])


@jax.jit
def play(street, stream):
    """Some steps of all environments: the stream, the limits of everything, the counts."""
    people = (street.world.rules.pedestrians, ENVIRONMENTS)
    idle = {"driver": jnp.zeros((2, ENVIRONMENTS)), "pedestrian": jnp.zeros(people, jnp.int32)}
    stream, (limits, counts) = rollout(
        street, act, stream, STEPS, fresh_memory=idle, keep=lambda step: look(street, step)
    )
    limits = jax.tree.map(_widest, limits)
    limits[f"driver {PRIVILEGED}"] = _limits(
        street.observe(stream.scenario, stream.state, street.view("driver", PRIVILEGED))
    )
    return stream, limits, jax.tree.map(jnp.sum, counts)


def _widest(limits):
    """Of limits ``(time, 2, feature)`` those of the whole time."""
    return jnp.stack([limits[:, 0].min(axis=0), limits[:, 1].max(axis=0)])


def run(steps, *, seed=0, told=print):
    """Play at least so many steps: the limits ``(2, feature)`` of everything by name, the counts, and the street."""
    street = Street.create(
        driver_weights=dict.fromkeys(DRIVER_TERMS, 1.0), pedestrian_weights=dict.fromkeys(PEDESTRIAN_TERMS, 1.0)
    )
    people = (street.world.rules.pedestrians, ENVIRONMENTS)
    idle = {"driver": jnp.zeros((2, ENVIRONMENTS)), "pedestrian": jnp.zeros(people, jnp.int32)}
    stream = jax.jit(start)(street, environment_keys(seed_key(seed, TRAINING), 0, ENVIRONMENTS), idle)
    seen, counts, begun, turn = {}, Counter(), time.monotonic(), 0
    while counts["steps"] < steps:
        here = with_jaywalk_multiplier(street, MULTIPLIERS[turn % len(MULTIPLIERS)])
        stream, limits, more = play(here, stream)
        seen = {name: _widest(np.stack([seen.get(name, x), x])) for name, x in limits.items()}
        counts += Counter({name: int(x) for name, x in more.items()})
        turn += 1
        if turn % 40 == 0:
            told(f"{counts['steps']:,} steps in {time.monotonic() - begun:,.0f} s")
    return street, {name: np.asarray(x) for name, x in seen.items()}, counts


def wrong(street, seen):
    """What is not finite or outside its bounds, one line each."""
    lines = [f"{name}: not finite at {np.flatnonzero(~np.isfinite(x).all(axis=0))}" for name, x in seen.items()
             if not np.isfinite(x).all()]  # fmt: skip
    for role, name in [*SETS, ("driver", PRIVILEGED)]:
        low, high = bounds(street.world, role, name)
        lowest, highest = seen[f"{role} {name}"]
        lines += [
            f"{role} {name}: feature {i} was in [{lowest[i]:g}, {highest[i]:g}], not within [{low[i]:g}, {high[i]:g}]"
            for i in np.flatnonzero((lowest < low) | (highest > high))
        ]
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=10_000_000, help="of one environment each (default: 10 million)")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    street, seen, counts = run(options.steps, seed=options.seed)
    print(", ".join(f"{counts[name]:,} {name}" for name in ("steps", *ENDINGS)))
    print(", ".join(f"{name}: {x.shape[1]} numbers" for name, x in seen.items()))
    lines = wrong(street, seen)
    print("\n".join(lines) if lines else "everything was finite, and every observation within its bounds")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
