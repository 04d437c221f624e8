"""Add a reward term: a function of one step. A recipe, or `Street.create`, gives it a weight."""

import jax
import jax.numpy as jnp

from jaxwalk import Street
from jaxwalk.sim.reward import DRIVER_TERMS


def harshness(step):
    """Return the deceleration in the step [m/s2]."""
    slower = step.before.vehicle.speed - step.after.vehicle.speed
    return jnp.maximum(slower, 0) / step.world.rules.dt


DRIVER_TERMS["harshness"] = harshness

street = Street.create(driver_weights={"progress": 0.5, "harshness": -0.1})
scenario = street.draw(jax.random.key(0))
state = street.reset(scenario)
for acceleration in (1.0, 1.0, -1.0):
    actions = {"driver": jnp.array([acceleration, 0.0]), "pedestrian": jnp.ones(12, int)}
    state, outcome = street.step(scenario, state, actions)
    print({name: round(float(term), 3) for name, term in outcome.rewards["driver"].items()})
