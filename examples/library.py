"""jaxwalk as a library: one scenario step by step, 512 at once, and a rollout with restarts."""

import jax
import jax.numpy as jnp

from jaxwalk import Street
from jaxwalk.rollout import TRAINING, draw_batch, environment_keys, rollout, seed_key, start

street = Street.create()

scenario = street.draw(jax.random.key(0))  # all random choices of an episode
state = street.reset(scenario)
state, outcome = street.step(scenario, state, {"driver": jnp.array([1.0, 0.0]), "pedestrian": jnp.ones(12, int)})
print(f"after one step the car drives {state.vehicle.speed:.1f} m/s; collision: {outcome.events.collision}")

keys = environment_keys(seed_key(0, TRAINING), 0, 512)
states = street.reset(draw_batch(street, keys))  # the same code: arrays end in the batch axis
print(f"512 scenarios, {states.pedestrian.x.size} people")


def act(key, scenario, state, memory):
    full_throttle = jnp.tile(jnp.array([[1.0], [0.0]]), 512)
    return {"driver": full_throttle, "pedestrian": jnp.ones((12, 512), int)}, memory, None


stream, steps = jax.jit(lambda stream: rollout(street, act, stream, 128))(start(street, keys))
print(f"{int(steps.outcome.events.collision.sum())} collisions in 128 steps of 512 streets")
