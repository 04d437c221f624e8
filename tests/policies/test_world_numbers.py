"""A rule's fields get the world's numbers where they say so, and no others."""

from __future__ import annotations

from dataclasses import fields, replace

import equinox as eqx
import pytest

from jaxwalk.policies import DRIVERS, POPULATIONS
from jaxwalk.policies.world_numbers import MARK, from_world, with_limits
from jaxwalk.sim.sim_config import SimConfig

WORLD = SimConfig(max_speed=20.0, pedestrians=5, horizon=7)


class Own(eqx.Module):
    """A rule with fields that are named like the world's, for something else."""

    top: float = from_world("max_speed")
    horizon: float = eqx.field(static=True, default=3.0)
    pedestrians: int = 2


def test_a_rule_has_the_usual_numbers_until_it_is_in_a_world():
    assert Own().top == SimConfig().max_speed
    assert with_limits(Own(), WORLD) == Own(top=20.0, horizon=3.0, pedestrians=2)


class Around(eqx.Module):
    """A rule around another one."""

    rule: Own
    top: float = eqx.field(static=True, default=1.0)


def test_a_rule_inside_another_one_knows_the_world_too():
    assert with_limits(Around(Own()), WORLD) == Around(Own(top=20.0))
    assert with_limits(DRIVERS["cautious"](), replace(WORLD, wheelbase=4.0)).rule.wheelbase == 4.0


def test_a_rule_that_knows_of_no_world_is_returned_as_it_is():
    rule = DRIVERS["random"]()
    assert with_limits(rule, WORLD) is rule
    assert with_limits(print, WORLD) is print


def test_a_number_that_no_world_has_is_an_error():
    with pytest.raises(AttributeError, match="max_sped"):
        from_world("max_sped")


@pytest.mark.parametrize("make", [*DRIVERS.values(), *POPULATIONS.values()], ids=[*DRIVERS, *POPULATIONS])
def test_our_rules_mark_what_they_know_of_the_world(make):
    """None of ours has a field that is named like the world's and means something else."""
    named = {x.name for x in fields(make()) if hasattr(SimConfig(), x.name)}
    assert {x.name for x in fields(make()) if x.metadata.get(MARK) == x.name} == named
