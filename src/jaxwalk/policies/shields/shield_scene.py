"""What a shield sees, and what it says of an action."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import equinox as eqx
from jaxtyping import Array, Bool, Float

from jaxwalk.interfaces import Moment, Shared, View
from jaxwalk.sim.scenario import Scenario, without_people
from jaxwalk.sim.state import Motion, VehicleState
from jaxwalk.sim.world import MapTexts, World


class ShieldScene(eqx.Module):
    """What the car knows: its street, itself, and the people that it perceives."""

    shared: Shared
    """The `World`."""
    scenario: Scenario
    """The car's map and route; there are no people in it."""
    car: VehicleState
    people: Motion
    """People as the car perceives them; who isn't perceived is `jaxwalk.sim.prediction.AWAY`. ``(ped, *batch)``."""

    @property
    def world(self) -> World:
        """Maps and rules."""
        return self.shared.value


@dataclass(frozen=True)
class Around:
    """The view of a shield."""

    name: str = "around"

    def __call__(self, moment: Moment) -> ShieldScene:
        """Return what the car knows."""
        state, scenario = moment.state, moment.scenario
        empty = without_people(scenario.map, scenario.route)
        world = replace(moment.world, map_texts=MapTexts())
        return ShieldScene(Shared(world), empty, state.vehicle, state.foresight.people)


class Verdict(eqx.Module):
    """What a shield says of an action."""

    safe: Bool[Array, "*batch"]
    """Whether the action is safe by the shield's rule; then it is kept."""
    instead: Float[Array, "2 *batch"]
    """What to do if it isn't."""
    infeasible: Bool[Array, "*batch"]
    """Whether the action isn't safe, and nor is what is done instead."""


@runtime_checkable
class Shield(Protocol):
    """A rule that says which actions are safe. It has no memory."""

    @property
    def view(self) -> View:
        """Return what it sees."""
        ...

    def judge(self, action: Float[Array, "2 *batch"], scene: ShieldScene, /) -> Verdict:
        """Return what it says of an action, which is in its space."""
        ...
