"""Evaluate a driver of your own: its collisions, its reaction to jaywalkers, and who could have avoided the collisions.

A driver is any object with ``view``, ``init`` and ``act`` (`jaxwalk.interfaces.Policy`).
"""

import equinox as eqx
import jax.numpy as jnp

from jaxwalk import Drawn, Street
from jaxwalk.evaluation import counterfactuals, evaluate, find_hits, paired, summarise_counterfactuals
from jaxwalk.interfaces import View
from jaxwalk.metrics import SPEED_DIFFERENTIAL, SURROGATES, summarise
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.report.surprise import in_words
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import Observation, part

EPISODES = 64  # use 2,000 or more for reliable numbers


class Cautious(eqx.Module):
    """Follows its route at 4 m/s or less, and ignores people."""

    view: View = eqx.field(static=True, default=Observation("driver", "route"))

    def init(self, agents, batch):
        return None

    def act(self, key, memory, observation):
        (_, steering), _ = RouteFollower().act(key, None, observation)
        speed = SPEED * observation[part("driver", "route", "speed")][0]
        return jnp.stack([jnp.where(speed < 4, 1.0, -1.0), steering]), memory


street = Street.create()
scenarios = Drawn(street, seed=0, count=EPISODES)
at_full_speed = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
cautious = {"driver": Cautious(), "pedestrian": AlwaysGo()}
fast, slow = (evaluate(street, policies, scenarios, batch=64) for policies in (at_full_speed, cautious))
collision = paired(fast, slow).collision
print("collisions at full speed {:.0%}, at 4 m/s {:.0%}; p = {:.3f}".format(*collision.rates, collision.p))

summary = summarise(slow)
print(in_words(summary[SPEED_DIFFERENTIAL]))
crosswalk = summary[SURROGATES].crosswalk
print(f"TTC below 1.5 s in {crosswalk.ttc_critical.value:.0%} of the encounters at crosswalks")

hits = find_hits(slow).first(8)
found = summarise_counterfactuals(counterfactuals(street, cautious, scenarios, hits, batch=64))
shares = ", ".join(f"{label} {rate.successes}" for label, rate in found.all.labels.items())
print(f"of {found.replayed} collisions replayed, avoidable by: {shares}")
judged = found.all.judged
print(f"a careful human would have avoided {judged.human.successes}, only an oracle {judged.oracle.successes}")
