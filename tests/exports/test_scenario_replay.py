"""Exported episodes, read back by our own reader and played again: everybody within a millimetre."""

from __future__ import annotations

import re

import numpy as np
import pytest

from exports.failures import POLICIES, kept_failure
from jaxwalk.exports.scenario_files import EPISODE, export_scenario
from jaxwalk.exports.scenario_replay import replayed_episode
from jaxwalk.formats.openscenario import read_openscenario
from jaxwalk.scenarios import Drawn

WITHIN = 1e-3
"""How far anybody may be from where the file has them [m]."""


@pytest.mark.usefixtures("scenario_library")
def test_a_kept_failure_is_the_same_failure_again(street, tmp_path):
    export_scenario(street, POLICIES, kept_failure(street), 0, tmp_path, name="a failure")
    file = tmp_path / EPISODE
    recorded = read_openscenario(file.read_bytes())
    again = replayed_episode(file, street.config)
    assert len(recorded) == 10 and again.trajectory.ped_x.shape[2] == 9
    assert again.error < WITHIN
    assert again.frames == len(recorded[0].t), "the contact comes at the same moment"
    assert again.trajectory.collision[0]
    assert [map.name for map in again.source.street.maps] == ["paper"]


@pytest.mark.long
@pytest.mark.usefixtures("scenario_library")
@pytest.mark.parametrize("named", [True, False], ids=["on its street", "on a street along the way of the car"])
@pytest.mark.parametrize("number", [0, 2, 5])
def test_episodes_are_the_same_again(street, tmp_path, number, named):
    export_scenario(street, POLICIES, Drawn(street, 0), number, tmp_path, name="an episode")
    file = tmp_path / EPISODE
    if not named:
        file.write_text(re.sub("<Property name=.jaxwalk[^>]*>", "", file.read_text()))
    again = replayed_episode(file, street.config)
    assert again.error < WITHIN
    assert again.frames == len(read_openscenario(file.read_bytes())[0].t)
    assert np.abs(again.source.script.speed).max() == 0, "the paper's car begins at rest"


def test_a_car_that_is_missing_is_named(street, tmp_path):
    file = tmp_path / "none.xosc"
    file.write_text(NO_CAR)
    with pytest.raises(ValueError, match="0 recorded cars; name an episode"):
        replayed_episode(file)


NO_CAR = """<OpenSCENARIO><FileHeader revMajor="1" revMinor="2"/><Entities><ScenarioObject name="Ego">
<Vehicle name="car" vehicleCategory="car"><BoundingBox><Center x="1.25" y="0" z="0"/>
<Dimensions length="4.5" width="1.8" height="1.5"/></BoundingBox></Vehicle></ScenarioObject></Entities>
<Storyboard><Init><Actions><Private entityRef="Ego"><PrivateAction><TeleportAction><Position>
<WorldPosition x="0" y="0"/></Position></TeleportAction></PrivateAction><PrivateAction><LongitudinalAction><SpeedAction>
<SpeedActionDynamics dynamicsShape="step" dynamicsDimension="time" value="0"/><SpeedActionTarget>
<AbsoluteTargetSpeed value="8"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction></Private>
</Actions></Init></Storyboard></OpenSCENARIO>"""
