"""What counts as a contact: the simulator ends episodes where the metric finds contacts, by either rule."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.evaluation.playing import play
from jaxwalk.interfaces import Moment
from jaxwalk.metrics import measure
from jaxwalk.metrics.contacts import MEASURED_CONTACTS, RULES
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.scenarios import Drawn
from jaxwalk.sim import events, manoeuvres, prediction
from jaxwalk.sim.sim_config import WORLDS, SimConfig, rules_of
from pytrees import as_numpy
from sim.play import compiled, reset

EPISODES = 64
clearance_by = compiled(prediction.clearance_by)


@pytest.fixture(scope="module", params=("paper", "paper-footprint"))
def played(request):
    """A world, and episodes of a driver who looks at nobody in it."""
    street = Street.create(config=WORLDS[request.param])
    scenarios, keys = Drawn(street, 5, EPISODES).take(np.arange(EPISODES))
    trajectory = play(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, scenarios, keys)
    return street, scenarios, trajectory


def test_the_rule_decides():
    car = SimConfig(contact="footprint")
    assert events.touching(car, 2.4, 0.0, 1.0, 0.0)  # in front of the bumper
    assert not events.touching(SimConfig(), 2.4, 0.0, 1.0, 0.0)
    assert not events.touching(car, 0.0, 1.4, 1.0, 0.0)  # beside the door
    assert events.touching(SimConfig(), 0.0, 1.4, 1.0, 0.0)
    assert events.touching(car, 0.0, -2.4, 0.0, -1.0)  # the car faces south
    assert not events.touching(car, 2.4, 0.0, 0.0, -1.0)


def test_episodes_end_at_the_first_contact_by_the_worlds_rule(played):
    street, _, trajectory = played
    table = measure(trajectory, config=street.config)[MEASURED_CONTACTS]
    mine = table.rule == RULES.index(street.config.contact)
    assert trajectory.collision.sum() > 10
    assert set(table.episode[mine]) == set(np.flatnonzero(trajectory.collision))
    assert (table.frame[mine] == trajectory.length[table.episode[mine]]).all()
    assert trajectory.touched[table.episode[mine], table.ped[mine]].all()
    assert mine.sum() == trajectory.touched.sum()
    assert len(set(table.rule)) == 2, "the other rule's contacts are counted too"


@pytest.mark.parametrize("rule", RULES)
def test_clearances_of_a_standing_car_by_hand(played, rule):
    street, scenarios, _ = played
    state = reset(street, scenarios)
    clearance, conflict = clearance_by(Moment(street.world, scenarios, state), rule)
    seen, config = as_numpy(state.foresight.people), street.config
    time = np.array(manoeuvres.MOMENTS[rule])[:, None, None]
    ahead, left = seen.ahead + seen.ahead_speed * time, seen.left + seen.left_speed * time
    if rule == "disc":
        away = np.hypot(ahead, left)
    else:
        away = np.maximum(events.to_rectangle(ahead, left, config.car_length, config.car_width) - config.body_radius, 0)
    near = away.min(axis=1)  # of the nearest person, in each moment
    body = 0 if rule == "disc" else config.body_radius
    np.testing.assert_allclose(clearance[manoeuvres.HOLD], np.minimum(near.min(axis=0), 10 - body), atol=1e-4)
    np.testing.assert_array_equal(clearance[manoeuvres.BRAKE], clearance[manoeuvres.HOLD])
    first = np.where(near < manoeuvres.CONFLICT[rule], time[:, 0], 3.0).min(axis=0)
    np.testing.assert_allclose(conflict[manoeuvres.HOLD], first, atol=1e-6)
    np.testing.assert_array_equal(conflict[manoeuvres.BRAKE], conflict[manoeuvres.HOLD])


def test_a_car_in_motion_comes_nearer_with_its_front_than_with_its_centre(played):
    street, scenarios, _ = played
    moment = Moment(street.world, scenarios, reset(street, scenarios))
    (centre, _), (front, _) = (clearance_by(moment, rule) for rule in RULES)
    assert (front <= centre).all()
    assert np.where(centre < 10, centre - front, 0).max() > 2.25, "ahead it is half a car's length and the body"


def test_rules_by_name():
    assert rules_of("paper-footprint", ("paper",)).contact == "footprint"
    assert rules_of(None, ("paper",)).contact == "disc"
    assert rules_of(None, ("mine.toml",)).contact == "footprint"
    with pytest.raises(ValueError, match="no world 'moon'; there are: paper, paper-footprint"):
        rules_of("moon", ())
    with pytest.raises(ValueError, match="contact must be one of disc, footprint, not 'cube'"):
        SimConfig.__post_init__(SimpleNamespace(**vars(SimConfig()) | {"contact": "cube"}))
