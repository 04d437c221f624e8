"""A population whose groups cross together: the leader decides, and the others do as it does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int, Key

from jaxwalk.interfaces import Moment, Policy, View

Company = tuple[Int[Array, "ped *batch"], Bool[Array, "ped *batch"], Any]
"""The number of each pedestrian's leader, who is a follower on a roadway, and what the people themselves see."""


@dataclass(frozen=True)
class InCompany:
    """What people see, and the leaders of their groups."""

    view: View

    @property
    def name(self) -> str:
        """The name of what people see."""
        return self.view.name

    def __call__(self, moment: Moment) -> Company:
        """Return the leaders, who goes on in any case, and what people see."""
        start, leader = moment.scenario.start, moment.scenario.leader
        own = jnp.broadcast_to(jnp.arange(len(start)).reshape(-1, *(1,) * (start.ndim - 1)), start.shape)
        leader = own if leader is None else leader
        return leader, (leader != own) & moment.state.pedestrian.on_roadway, self.view(moment)


class Groups(eqx.Module):
    """People of another population, but whoever walks in a group waits and goes when its leader does.

    A follower on a roadway goes on, also if the leader waits already at the next kerb. Where nobody walks in groups it
    is the other population.
    """

    people: Policy
    """The policy of everybody who decides."""

    @property
    def view(self) -> View:
        """What it sees."""
        return InCompany(self.people.view)

    @property
    def sample(self) -> bool:
        """Whether people draw their actions at random."""
        return getattr(self.people, "sample", False)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Any:
        """Return the people's memories."""
        return self.people.init(agents, batch)

    def act(self, key: Key[Array, "*batch"], memory: Any, seen: Company) -> tuple[Int[Array, "ped *batch"], Any]:
        """Return who goes, and the next memories. Everybody decides, and a leader's decision counts for its group."""
        leader, goes_on, view = seen
        action, after = self.people.act(key, memory, view)
        together = jnp.take_along_axis(action, leader, axis=0, mode="promise_in_bounds")
        return jnp.where(goes_on, 1, together), after
