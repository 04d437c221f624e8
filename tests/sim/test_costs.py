"""What a step costs: states made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.sim.cost import DRIVER_COSTS
from jaxwalk.sim.manoeuvres import HOLD
from sim.play import ENVIRONMENTS, actions, everything, with_car

BRAKE = (-1.0, 0.0)
COAST = (0.0, 0.0)


def test_a_contact_costs_1_and_the_speed_of_the_car(paid_street, crossing_person):
    scenario, state, p = crossing_person
    away = np.full(ENVIRONMENTS, 1.9, np.float32)
    away[1] = 3.0
    state = with_car(
        state, x=np.asarray(state.pedestrian.x)[p] - away, y=state.pedestrian.y[p], cos=1.0, sin=0.0, speed=5.0
    )
    _, outcome, _, _ = everything(paid_street, scenario, state, actions(BRAKE, 0))
    costs = {name: np.asarray(cost) for name, cost in outcome.costs["driver"].items()}
    assert costs.keys() == DRIVER_COSTS.keys()
    assert list(outcome.costs) == ["driver"]
    # 3 m/s2 for 0.1 s: 4.7 m/s; it drives 0.47 to 0.5 m, to within 1.5 m of the centre, and from 3 m it doesn't
    np.testing.assert_array_equal(costs["contact"], np.arange(ENVIRONMENTS) != 1)
    np.testing.assert_allclose(costs["impact_speed"], 4.7 * costs["contact"], atol=1e-5)


def test_a_moving_car_is_charged_while_a_conflict_is_near(paid_street, scenarios, midway):
    for speed in (0.3, 8.0):
        after, outcome, _, _ = everything(paid_street, scenarios, with_car(midway, speed=speed), actions(COAST))
        near = np.asarray(after.foresight.conflict[HOLD]) < 1.5
        assert near.any() and not near.all()
        expected = np.where(near, 0.1 * (speed >= 0.5), 0)
        np.testing.assert_allclose(outcome.costs["driver"]["critical_time"], expected, rtol=1e-6)


def test_a_cost_that_does_not_exist_is_refused():
    from jaxwalk import Street

    with pytest.raises(ValueError, match=r"costs\.driver\.noise is no cost; there are: contact, impact_speed"):
        Street.create(driver_costs=("noise",))
