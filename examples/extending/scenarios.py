"""Add a kind of scenario: a source that returns scenarios by their numbers."""

import equinox as eqx

from jaxwalk import Street, evaluate, summarise
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.scenarios import Drawn, source_hash


class Reckless:
    """Drawn scenarios in which everybody has a jaywalking tendency of 1."""

    def __init__(self, drawn):
        """Change the scenarios of ``drawn``."""
        self.drawn = drawn

    def __len__(self):
        """Return the number of scenarios."""
        return len(self.drawn)

    def take(self, numbers):
        """Return the scenarios with these numbers as one batch, and a random key for each."""
        scenarios, keys = self.drawn.take(numbers)
        return eqx.tree_at(lambda x: x.traits, scenarios, scenarios.traits.at[0].set(1.0)), keys

    def hash(self):
        """Return digits that identify the set of scenarios."""
        return source_hash(self)

    def describe(self):
        """Return what results say about the set."""
        return {"kind": "reckless", "count": len(self), "hash": self.hash()}


street = Street.create()
drawn = Drawn(street, seed=0, count=64)
for source in (drawn, Reckless(drawn)):
    rows = evaluate(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, source, batch=64)
    print(f"{source.describe()}: collisions in {summarise(rows)[OUTCOMES].collision.value:.0%}")
