"""Add a feature to what a driver observes: one entry with its name, size, bounds and formula."""

import jax
import jax.numpy as jnp

from jaxwalk import Street
from jaxwalk.sim.driver_features import ROUTE
from jaxwalk.sim.features import Feature, share
from jaxwalk.sim.observation import OBSERVATIONS, bounds, part, size


def crowd(moment):
    """Return the share of the six nearest pedestrians who are less than 4 m to the side of the car."""
    return (jnp.mean(jnp.abs(moment.state.foresight.nearest.left) < 4, axis=0),)


OBSERVATIONS["driver"]["route-crowd"] = (*ROUTE, Feature("crowd", 1, share, crowd, ("all six of them",)))

street = Street.create()
scenario = street.draw(jax.random.key(0))
view = street.view("driver", "route-crowd")  # a recipe may name it too: observes="route-crowd"
seen = street.observe(scenario, street.reset(scenario), view)
low, high = bounds(street.world, "driver", "route-crowd")
assert ((low <= seen) & (seen <= high)).all()
print(f"{size('driver', 'route-crowd')} numbers; crowd is {seen[part('driver', 'route-crowd', 'crowd')].item():.2f}")
