"""Add a driver: a policy that names its view and returns an action for each moment that it sees."""

import equinox as eqx
import jax.numpy as jnp

from jaxwalk import DRIVERS, Street, evaluate, summarise
from jaxwalk.interfaces import View
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.observation import Observation, part


class Yielding(eqx.Module):
    """Follows its route, and brakes if a pedestrian is predicted to come closer than 2.5 m at the current speed."""

    view: View = eqx.field(static=True, default=Observation("driver", "route"))

    def init(self, agents, batch):
        """Return None: it has no memory."""
        return None

    def act(self, key, memory, observation):
        """Return acceleration and steering, each in [-1, 1], and the next memory."""
        (_, steering), _ = RouteFollower().act(key, None, observation)
        _braking, held, _accelerating = 10 * observation[part("driver", "route", "clearance")]  # [m]
        return jnp.stack([jnp.where(held < 2.5, -1.0, 1.0), steering]), memory


DRIVERS["yielding"] = Yielding

street = Street.create()
scenarios = Drawn(street, seed=0, count=64)
for name in ("route-follower", "yielding"):
    rows = evaluate(street, {"driver": DRIVERS[name](), "pedestrian": AlwaysGo()}, scenarios, batch=64)
    print(f"{name}: collisions in {summarise(rows)[OUTCOMES].collision.value:.0%} of {len(scenarios)} scenarios")
