"""Numbers of the world that a rule knows of, such as the car's top speed: fields that are set for each world."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, TypeVar

import equinox as eqx

from jaxwalk.sim.sim_config import SimConfig

MARK = "number_of_the_world"
"""The key in a field's metadata; its value is the name of the number in `SimConfig`."""

P = TypeVar("P")


def from_world(name: str) -> Any:
    """Return a field for a rule's class whose value is a number of `SimConfig`: the usual one, until `with_limits`.

    The field itself may have another name. Raise AttributeError if `SimConfig` has no such number.
    """
    return eqx.field(static=True, default=getattr(SimConfig, name), metadata={MARK: name})


def with_limits(policy: P, config: SimConfig) -> P:
    """Return the rule for a world's car: its fields that are made by `from_world` have the world's numbers.

    So have those of a rule inside it.
    """
    if not isinstance(policy, eqx.Module):
        return policy
    marked = {x.name: getattr(config, x.metadata[MARK]) for x in fields(policy) if MARK in x.metadata}
    inside = {
        x.name: getattr(policy, x.name) for x in fields(policy) if isinstance(getattr(policy, x.name), eqx.Module)
    }
    known = {name: with_limits(rule, config) for name, rule in inside.items()}
    changed = marked | {name: rule for name, rule in known.items() if rule is not inside[name]}
    return replace(policy, **changed) if changed else policy
