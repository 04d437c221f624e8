"""Evaluate a driver of your own: its collisions, its reaction to jaywalkers, and who could have avoided the collisions.

A driver is any object with ``observes``, ``init`` and ``act`` (`jaxwalk.interfaces.Policy`).
"""

import equinox as eqx
import jax.numpy as jnp

from jaxwalk import Street
from jaxwalk.evaluation import counterfactuals, evaluate, paired, summarise_counterfactuals
from jaxwalk.metrics import SURROGATES, summarise
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.report.surprise import in_words
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.observation import SPEED, part

EPISODES = 64  # use 2,000 or more for reliable numbers


class Cautious(eqx.Module):
    """Follows its route at 4 m/s or less, and ignores people."""

    observes: str = eqx.field(static=True, default="route")

    def init(self, agents, batch):
        return None

    def act(self, key, memory, observation):
        (_, steering), _ = RouteFollower().act(key, None, observation)
        speed = SPEED * observation[part("driver", "route", "speed")][0]
        return jnp.stack([jnp.where(speed < 4, 1.0, -1.0), steering]), memory


street = Street.create()
fast, slow = (
    evaluate(street, {"driver": car, "pedestrian": AlwaysGo()}, Drawn(street, 0, EPISODES), batch=64)
    for car in (RouteFollower(), Cautious())
)
collision = paired(fast, slow).collision
print("collisions at full speed {:.0%}, at 4 m/s {:.0%}; p = {:.3f}".format(*collision.rates, collision.p))

summary = summarise(slow)
print(in_words(summary.as_dict()["speed_differential"]))
crosswalk = summary[SURROGATES].crosswalk
print(f"TTC below 1.5 s in {crosswalk.ttc_critical.value:.0%} of the encounters at crosswalks")

found = summarise_counterfactuals(counterfactuals(street, Cautious(), AlwaysGo(), slow, seed=0, batch=64, at_most=8))
shares = ", ".join(f"{label} {rate.successes}" for label, rate in found.all.labels.items())
print(f"of {found.replayed} collisions replayed, avoidable by: {shares}")
