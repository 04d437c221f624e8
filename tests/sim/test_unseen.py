"""Sets of what a car doesn't see: x-ray, who was last seen, hidden sides; and critics, which see the truth."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.learning.casting import whole
from jaxwalk.learning.critics import make_critics
from jaxwalk.learning.experience import gather_views
from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.recipes import FAST
from jaxwalk.sim.cost import counted
from jaxwalk.sim.manoeuvres import HOLD
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.observation import AWARE, FOOTPRINT, MEMORY, part
from jaxwalk.sim.perceived import KEPT
from jaxwalk.sim.prediction import DISTANCE, NEIGHBOURS, foresee
from jaxwalk.sim.reward import Transition
from jaxwalk.sim.sight import in_sight
from jaxwalk.sim.sim_config import SimConfig
from pytrees import as_numpy
from sim.hiding import BATCH, drawn, drive, hiding_street, look, play_on, x_ray
from sim.play import compiled


@pytest.fixture(scope="module")
def hiding():
    return hiding_street()


@pytest.fixture(scope="module")
def scenarios(hiding):
    return drawn(hiding)


@pytest.fixture(scope="module")
def played(hiding, scenarios):
    return drive(hiding, scenarios)


@pytest.fixture(scope="module")
def usual(hiding):
    """The same street without perception: nobody is hidden."""
    return replace(hiding, world=replace(hiding.world, rules=replace(hiding.world.rules, perception=False)))


@pytest.fixture(scope="module")
def everybody(usual, scenarios):
    """The state after the same steps there."""
    state, _ = play_on(usual, scenarios)
    return state


def test_the_x_ray_set_is_what_a_car_sees_where_nobody_is_hidden(hiding, usual, scenarios, played, everybody):
    """Played again without perception: the same people, and so the same set, which hides nobody there."""
    state, _ = played
    blind, sees_all = (as_numpy(look(usual, scenarios, x, FOOTPRINT)) for x in (state, everybody))
    np.testing.assert_allclose(x_ray(hiding, scenarios, state), sees_all, atol=2e-3)
    np.testing.assert_array_equal(x_ray(usual, scenarios, everybody), sees_all)
    assert (np.abs(blind - sees_all).max(axis=0) > 0.1).mean() > 0.5


def test_critics_see_what_is_hidden_and_actors_do_not(hiding, scenarios, played):
    """Under names of their own, which the critics read; the reward goes by the same truth."""
    config, (state, _) = whole(replace(FAST.train, environments=BATCH)), played
    views = compiled(partial(gather_views, hiding, config))(scenarios, state)
    shapes = jax.eval_shape(lambda x: x, views)
    critics = eqx.filter_eval_shape(partial(make_critics, hiding, config.config, shapes), jax.random.key(0))  # names
    driver, kerb = (critics[role].reads for role in ("driver", "pedestrian"))
    assert (len(driver), driver[1], len(kerb)) == (2, "global", 1)
    own = config.columns["driver"].own
    np.testing.assert_allclose(views["driver"][driver[0]], x_ray(hiding, scenarios, state)[:, own], atol=1e-4)
    blind = as_numpy(look(hiding, scenarios, state, FOOTPRINT))
    np.testing.assert_allclose(views["driver"][FOOTPRINT], blind[:, own], atol=1e-4)
    own = config.columns["pedestrian"].own
    car = part("pedestrian", "kerb", "car_motion")
    unseen = ~np.asarray(state.perceived.in_sight)[:, own]
    assert not views["pedestrian"]["kerb"][car][:, unseen].any()
    assert views["pedestrian"][kerb[0]][car][:, unseen].any()
    assert {name: list(seen) for name, seen in views.items()} == {
        "driver": ["global", FOOTPRINT, driver[0]], "pedestrian": ["kerb", kerb[0]]
    }  # fmt: skip


def test_costs_go_by_the_truth(hiding, scenarios, played):
    """Somebody stands 8 m ahead of a car at 12 m/s, and isn't seen: the car is charged all the same."""
    (state, _), ahead = played, 8.0
    car, leg, left = as_numpy((state.vehicle, state.pedestrian.leg, state.pedestrian.remaining))
    end_x, end_y = leg.end_x.copy(), leg.end_y.copy()
    end_x[0] = car.x + ahead * car.cos + leg.cos[0] * left[0]
    end_y[0] = car.y + ahead * car.sin + leg.sin[0] * left[0]
    nobody = np.zeros(left.shape, bool)
    fast = eqx.tree_at(
        lambda s: (s.vehicle.speed, s.pedestrian.leg.end_x, s.pedestrian.leg.end_y, s.pedestrian.going,
                   s.perceived.now.seen),
        state, (np.full(BATCH, 12.0, np.float32), end_x, end_y, nobody, nobody),
    )  # fmt: skip

    @compiled
    def charged(state):
        step = Transition(hiding.world, scenarios, state, state, None)
        truth = foresee(hiding.world, scenarios, state.vehicle, state.pedestrian)
        seen = foresee(hiding.world, scenarios, state.vehicle, state.pedestrian, state.perceived)
        return counted(("critical_time",), step)["critical_time"], truth.conflict[HOLD], seen.conflict[HOLD]

    cost, true, seen = charged(fast)
    np.testing.assert_allclose(cost, 0.1 * (true < 1.5), rtol=1e-6)
    # 2.25 m to the bumper, 0.25 m of body, 0.3 m of margin: 5.2 m in 0.43 s; it is looked at after 0.4 and 0.55 s
    assert (true[true < 1.5] == np.float32(0.55)).all()
    assert (true < 1.5).sum() > 8, "where the route doesn't turn off before them"
    assert (seen == 3).all()


def test_where_nobody_is_hidden_critics_and_actors_share_what_they_see():
    street = Street.create(config=SimConfig(pedestrians=3))
    scenario = drawn(street)
    config = whole(replace(FAST.train, environments=BATCH))

    def seen(scenario):
        state = street.reset(scenario)
        assert street.unhidden(scenario, state) is state
        return gather_views(street, config, scenario, state)

    views = jax.eval_shape(seen, scenario)
    assert {name: list(seen) for name, seen in views.items()} == {
        "driver": ["global", FOOTPRINT],
        "pedestrian": ["kerb"],
    }


def seen_by(street, scenarios, state, name, feature):
    observed = np.asarray(look(street, scenarios, state, name))
    return observed[part("driver", name, feature)]


def test_who_was_last_seen_is_shown_where_that_was_and_fades(hiding, scenarios, played):
    """Against plain arithmetic in the map's axes, for everybody who was lost in the last three seconds."""
    state, _ = played
    knows, car = as_numpy((state.perceived, state.vehicle))
    lost = knows.last.seen & ~knows.now.seen
    assert lost.any(axis=0).sum() > 3
    rows = seen_by(hiding, scenarios, state, MEMORY, "last_seen").reshape(NEIGHBOURS, 5, BATCH)
    for episode in range(BATCH):
        away = np.stack([knows.last.x - car.x, knows.last.y - car.y])[:, lost[:, episode], episode]
        order = np.argsort(np.hypot(*away))[:NEIGHBOURS]
        there = len(order)
        ahead = (away[0] * car.cos[episode] + away[1] * car.sin[episode])[order]
        fresh = 1 - knows.age[lost[:, episode], episode][order] / KEPT
        np.testing.assert_allclose(rows[:there, 0, episode], ahead / DISTANCE, atol=1e-4)
        np.testing.assert_allclose(rows[:there, 4, episode], np.maximum(fresh, 0), atol=1e-4)
        np.testing.assert_array_equal(rows[there:, :, episode], np.tile([1.0, 0, 0, 0, 0], (NEIGHBOURS - there, 1)))


def test_hidden_sides_are_those_that_no_line_reaches(hiding, usual, scenarios, played, everybody):
    """Places beyond the kerbs beside the points of the route ahead; where everybody is in sight none is hidden."""
    state, _ = played
    hidden = seen_by(hiding, scenarios, state, AWARE, "hidden_sides").reshape(len(POINTS), 2, BATCH)
    assert 0.05 < hidden.mean() < 0.95
    seen_from = compiled(in_sight)
    at = np.round(np.asarray(state.vehicle.along) / ROUTE_SPACING).astype(int)
    for point, ahead in enumerate(POINTS):
        index = at + int(ahead * POINT_SPACING / ROUTE_SPACING)
        beside = np.asarray(hiding.world.kerbsides)[scenarios.map, scenarios.route, index]
        for side in range(2):
            x, y = beside[:, 2 * side][None], beside[:, 2 * side + 1][None]
            seen = seen_from(hiding.world, scenarios, state.vehicle, x, y)[0]
            assert (hidden[point, side] == ~seen).mean() > 0.95
    assert not seen_by(usual, scenarios, everybody, AWARE, "hidden_sides").any()
    assert (seen_by(usual, scenarios, everybody, MEMORY, "last_seen").reshape(NEIGHBOURS, 5, BATCH)[:, 4] == 0).all()
