"""The knobs of drivers: the names, the settings, and that turning one changes the driver and nothing else."""

from __future__ import annotations

import equinox as eqx
import pytest

from jaxwalk.policies import DRIVERS
from jaxwalk.policies.knobs import KNOBS
from jaxwalk.policies.policy_names import ON_THE_FRONTIER, WITH_KNOB
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.sim.sim_config import WORLDS


def test_the_names_are_those_of_the_command_line():
    assert tuple(KNOBS) == WITH_KNOB
    assert set(WITH_KNOB) <= set(DRIVERS) and set(WITH_KNOB) < set(ON_THE_FRONTIER)


@pytest.mark.parametrize("name", KNOBS)
def test_the_usual_setting_is_the_driver_itself(name):
    knob, town = KNOBS[name], WORLDS["town"]
    assert knob.usual in knob.settings
    made = [with_limits(knob.turned(setting), town) for setting in knob.settings]
    own = with_limits(DRIVERS[name](), town)
    assert [bool(eqx.tree_equal(own, one)) for one in made] == [setting == knob.usual for setting in knob.settings]
    assert len({knob.label(name, setting) for setting in knob.settings}) == len(knob.settings)


def test_labels():
    assert KNOBS["clearance"].label("clearance", 0.5) == "clearance 0.5 m"
    assert KNOBS["belief-planner"].label("belief-planner", 3.0) == "belief-planner 3"
    assert KNOBS["belief-planner-chance"].label("belief-planner-chance", 0.001) == "belief-planner-chance 0.1 %"
    assert KNOBS["belief-planner-cvar"].label("belief-planner-cvar", 0.99) == "belief-planner-cvar 1 %"
