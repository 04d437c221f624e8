"""The error for a policy whose action isn't in its space: whatever plays it stops with a message that names it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from jaxwalk.interfaces import Box, Roles, RoleSpec

ADVICE = "the policy is broken (perhaps its network's numbers aren't finite): train it again, restore or correct it"


class ActionError(ValueError):
    """A policy's action isn't in its space. The message names policy, scenario and step, in one line."""

    def __init__(self, role: str, what: str, name: str | None = None) -> None:
        """Keep the role and what is wrong; ``name`` is the policy's, which the message has instead of the role."""
        super().__init__(f"{name or role}: {what}")
        self.role, self.what = role, what

    @classmethod
    def of(cls, role: str, spec: RoleSpec, actions: np.ndarray, *, scenario: int, step: int) -> ActionError:
        """Return the error for the actions of a role's agents at one step, ``(size, *agents)`` or ``(*agents,)``."""
        inside = np.asarray(spec.action.contains(actions))
        first = tuple(np.argwhere(~inside)[0])
        numbers = np.atleast_1d(actions[(..., *first)])
        value = f"[{' '.join(f'{x:g}' for x in numbers)}]" if isinstance(spec.action, Box) else f"{numbers[0]}"
        who = "".join(f", {role} {index}" for index in first)
        return cls(role, f"its action is {value}, not {spec.action} (scenario {scenario}, step {step}{who}); {ADVICE}")

    def by(self, names: Roles[str]) -> ActionError:
        """Return the same error with the policy's name, from the names of all roles' policies."""
        return ActionError(self.role, self.what, names[self.role])


@contextmanager
def named(names: Roles[str]) -> Iterator[None]:
    """Name the policy of an ActionError raised inside, by its role."""
    try:
        yield
    except ActionError as error:
        raise error.by(names) from error
