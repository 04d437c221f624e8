"""The belief planner: its plans, its futures and their costs, worked out by hand; and what it does with them."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.policies import DRIVERS
from jaxwalk.policies.belief_planner import EXCLUDED, BeliefPlanner
from jaxwalk.policies.people_futures import NEVER, PeopleBelief, dashes
from jaxwalk.policies.planner_scene import HiddenPlaces, PeopleAhead, PlannerScene
from jaxwalk.policies.speed_plans import PLANS, driven, speed_plans
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.sim.corridor import NEARING
from jaxwalk.sim.person_kind import in_shares
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.testing import check_driver
from pytrees import as_numpy

PLANNERS = ["belief-planner", "belief-planner-chance", "belief-planner-cvar"]
BESIDE, DT = 1.15, 0.1
"""The car's way: half its width and a body's radius [m]. The duration of a step [s]."""
ROUTE = jnp.asarray(np.zeros((16, 1), np.float32))
PLAIN = BeliefPlanner(PeopleBelief(futures=8), room_aside=0.0, room_ahead=0.0, contact="footprint")

# Compiled as a whole: each operation by itself would be a program of its own, for every shape.
drives = jax.jit(driven)
plans_of = eqx.filter_jit(speed_plans)
plans_at = eqx.filter_jit(lambda plans, time: plans.at(time))
walk_on = eqx.filter_jit(lambda belief, seen: belief.walk_on(seen, BESIDE))
step_out = eqx.filter_jit(lambda belief, seen: belief.step_out(seen, None, BESIDE, ()))
met = eqx.filter_jit(lambda planner, plans, one: planner.met(plans, one))
met_braking = eqx.filter_jit(lambda planner, plans, one: planner.met_braking(plans, one))
judge = eqx.filter_jit(lambda planner, seen: planner.judge(seen))
best_pedal = eqx.filter_jit(lambda planner, seen: planner.best_pedal(seen))
act = eqx.filter_jit(lambda planner, *now: planner.act(*now))


def column(*values):
    """An array of one episode."""
    return jnp.asarray(np.array(values, np.float32)[:, None])


def people(*rows):
    """People of (along, left, along_speed, left_speed), nobody of whom nears a crosswalk or jaywalks."""
    along, left, along_speed, left_speed = (column(*x) for x in zip(*rows, strict=True))
    nearing, none = (jnp.asarray(np.full(along.shape, x, np.float32)) for x in (NEARING, 0))
    nobody = jnp.asarray(np.zeros(along.shape, bool))
    return PeopleAhead(along, left, along_speed, left_speed, nearing, none, nobody, nobody)


def scene(seen, speed=8.0, top=8.0, places=None):
    return PlannerScene(one_car(speed), one_car(top), ROUTE, seen, places)


def one_car(speed):
    return jnp.asarray(np.full(1, speed, np.float32))


def plans_from(speed, top=8.0, max_acceleration=3.0, max_braking=3.0):
    return plans_of(one_car(speed), one_car(top), max_acceleration, max_braking)


def plan(pedal, lasts, then):
    """The index of a plan."""
    return int(np.flatnonzero((np.array([pedal, lasts, then]) == PLANS).all(axis=1))[0])


@pytest.mark.parametrize(
    ("speed", "acceleration", "time", "way", "after"),
    [
        (5.0, -3.0, 1.0, 3.5, 2.0),
        (5.0, -3.0, 9.0, 25 / 6, 0.0),
        (5.0, 2.0, 1.0, 6.0, 7.0),
        (5.0, 2.0, 2.5, 5 * 1.5 + 1.5**2 + 8, 8.0),
        (5.0, 0.0, 3.0, 15.0, 5.0),
        (9.0, 2.0, 1.0, 9.0, 9.0),
    ],
)
def test_a_constant_acceleration_ends_at_a_stand_or_at_the_top_speed(speed, acceleration, time, way, after):
    found = drives(*(np.float32(x) for x in (speed, acceleration, time, 8.0)))
    np.testing.assert_allclose(found, (way, after), rtol=1e-6, atol=1e-6)


def test_a_plan_is_driven_by_hand():
    way, speed = as_numpy(plans_at(plans_from(6.0, max_acceleration=2.0), np.float32(1.5)))
    braking = plan(-1.0, 0.4, 1.0)  # 0.4 s at -3 m/s2 to 4.8 m/s, then 1.1 s at 2 m/s2
    np.testing.assert_allclose((way[braking, 0], speed[braking, 0]), (2.16 + 4.8 * 1.1 + 1.21, 7.0), rtol=1e-6)
    gentle = plan(-0.4, 2.0, 0.0)  # -1.2 m/s2
    np.testing.assert_allclose((way[gentle, 0], speed[gentle, 0]), (9 - 0.6 * 2.25, 4.2), rtol=1e-6)


def test_who_walks_on_is_in_the_way_from_edge_to_edge():
    seen = people((10, 3, 0, -1), (10, 1, 0, -1), (10, 0, 0, 0), (10, 2, 0, 0), (10, 3, 0, 1), (10, -3, 0, 2))
    found = as_numpy(walk_on(PeopleBelief(), seen))
    np.testing.assert_allclose(found.enters[:, 0], [1.85, 0, 0, NEVER, 0, 0.925], atol=1e-6)
    np.testing.assert_allclose(found.leaves[:, 0], [4.15, 2.15, NEVER, 0, -1.85, 2.075], atol=1e-5)
    assert (found.weight == 1).all()


def test_futures_of_somebody_are_all_that_may_happen():
    belief = PeopleBelief(futures=8, within=4.0, hazard=0.5, takes_crosswalk=0.4)
    seen = replace(people((10, 4, 1, 0)), jaywalks=column(0.3), to_crosswalk=column(2.0))
    walking, stepping = as_numpy((walk_on(belief, seen), step_out(belief, seen)))
    takes = 0.4 * 0.7
    assert walking.weight.item() == pytest.approx((1 - takes) * np.exp(-0.5 * 0.3 * 4))
    assert (walking.weight.sum() + stepping.weight.sum()).item() == pytest.approx(1)
    crosswalk = jax.tree.map(lambda x: x[0, 0].item(), stepping)
    assert crosswalk == pytest.approx((takes, 12.0, 2.0, 2 + 2.85, 2 + 2.85 + 2.3))
    first = jax.tree.map(lambda x: x[1, 0].item(), stepping)
    assert first == pytest.approx(
        ((1 - takes) * (1 - np.exp(-0.15 * 0.5)), 10.25, 0.25, 0.25 + 2.85, 0.25 + 2.85 + 2.3)
    )


def test_runners_come_at_the_quartiles_of_their_speeds():
    assert dashes(()) == dashes(in_shares(calm=1.0)) == (0.0,)
    (runner,) = (kind for kind in in_shares(calm=0.5, hurried=0.5) if kind.jaywalk is not None)
    slowest, fastest = runner.jaywalk
    assert dashes(in_shares(calm=0.5, hurried=0.5)) == pytest.approx(
        (0.75 * slowest + 0.25 * fastest, 0.25 * slowest + 0.75 * fastest)
    )


def test_contacts_with_somebody_who_crosses_by_hand():
    """Somebody is in the way, 20 m ahead, from 1.85 to 4.15 s; a car at 8 m/s touches bodies 2.5 m ahead: at 2.19 s."""
    walking = as_numpy(walk_on(PeopleBelief(), people((20, 3, 0, -1))))
    plans = plans_from(8.0)
    meets, speed, when = as_numpy(met(PLAIN, plans, jax.tree.map(lambda x: x[0], walking)))
    held, braking = plan(0.0, 0.4, 1.0), plan(-1.0, 0.4, -1.0)
    assert meets[held, 0] and speed[held, 0] == pytest.approx(8)
    assert when[held, 0] == pytest.approx(1.85 + 2.3 * (20 - 2.5 - 14.8) / (8 * 2.3), abs=1e-3)
    assert not meets[braking, 0]  # it stands after 64 / 6 = 10.67 m, and 17.5 m are free
    near = as_numpy(walk_on(PeopleBelief(), people((8, 0, 0, 0))))
    meets, _, _ = as_numpy(met(PLAIN, plans, jax.tree.map(lambda x: x[0], near)))
    assert meets.all()  # nobody stops within 5.5 m


@pytest.mark.parametrize(("along", "speed"), [(16, (64 - 6 * (16 - 2.5 - 5.6)) ** 0.5), (12, 8 - 3 * 0.8)])
def test_contacts_with_somebody_who_steps_out_by_hand(along, speed):
    """Seen at 0.5 s, in the way from 1.5 s on; from 0.7 s, after 5.6 m, the car brakes fully.

    Whoever is 12 m ahead runs into its side; whoever is 16 m ahead, before its front.
    """
    belief, seen = PeopleBelief(futures=1, within=1.0, hazard=1.0), people((along, 1.65, 0, 1.0))
    stepping = as_numpy(step_out(belief, replace(seen, jaywalks=column(1.0))))
    future = jax.tree.map(lambda x: x[1], stepping)
    assert (future.seen.item(), future.enters.item()) == pytest.approx((0.5, 1.5))  # 2.15 m to the side by then
    meets, impact, _ = as_numpy(met_braking(PLAIN, plans_from(8.0), future))
    held = plan(0.0, 0.4, 1.0)
    assert meets[held, 0]
    assert impact[held, 0] == pytest.approx(speed, rel=1e-4)


def test_the_cost_of_a_plan_by_hand():
    """Held top speed costs nothing but contacts; these cost v2 + standing times the contact cost, discounted."""
    judged = as_numpy(judge(PLAIN, scene(people((100, 5, 0, 0)))))
    held, braking = plan(0.0, 0.4, 1.0), plan(-1.0, 0.4, -1.0)
    assert judged[held, 0] == pytest.approx(0, abs=1e-6)
    lost = PLAIN.discount ** np.arange(1, 16)
    speeds = np.maximum(8 - np.arange(1, 16), 0)  # 3 m/s2, three decisions in a second
    slow = PLAIN.slow_cost * (1 - speeds / 8) + PLAIN.change_cost * (np.arange(1, 16) <= 8)
    regained = PLAIN.discount**15 * PLAIN.slow_cost * 3 * 8 / (2 * PLAIN.max_acceleration)
    assert judged[braking, 0] == pytest.approx((lost * slow).sum() + regained, rel=1e-4)
    contact = float(eqx.filter_jit(PLAIN.contact_costs)(np.float32(8), np.float32(2)))
    assert contact == pytest.approx(PLAIN.contact_cost * (64 + PLAIN.standing) * 0.95**6, rel=1e-5)


@pytest.mark.parametrize("tail", [0.0, 0.5, 0.9])
def test_the_tail_is_the_mean_of_the_worst_futures(tail):
    """A contact at 3 m/s has a probability of 0.2: of the worst 1 - tail of the futures, min(1, 0.2 / (1 - tail))."""
    planner = replace(PLAIN, tail=tail, contact_cost=1.0, standing=0.0, discount=1.0)

    @jax.jit
    def extra(plans):
        shape = plans.middle_way.shape
        contact = jnp.ones(shape, bool), jnp.full(shape, 3.0), jnp.zeros(shape)
        found = planner._add(planner._nothing(plans), jnp.float32(0.2), *contact)
        return planner._total(plans, *found) - planner.way_costs(plans)

    np.testing.assert_allclose(extra(plans_from(8.0)), min(1, 0.2 / (1 - tail)) * 9, rtol=1e-4)


def test_plans_with_too_many_contacts_are_excluded():
    judged = as_numpy(judge(replace(PLAIN, tolerated=0.01), scene(people((20, 3, 0, -1)))))
    assert judged[plan(0.0, 0.4, 1.0), 0] >= EXCLUDED > judged[plan(-1.0, 0.4, -1.0), 0]


@pytest.mark.parametrize("name", PLANNERS)
def test_it_drives_on_alone_and_stops_short_of_who_stands_in_the_way(name):
    planner, at, speed = replace(DRIVERS[name](), contact="footprint"), 0.0, 8.0
    keys, memory = jax.random.split(jax.random.key(0), 1), planner.init((), (1,))
    alone, _ = act(planner, keys, memory, scene(people((99, 20, 0, 0))))
    assert np.asarray(alone)[0].item() == 1
    for _ in range(100):
        seen = scene(people((30 - at, 0, 0, 0)), speed=speed)
        action, memory = act(planner, keys, memory, seen)
        speed = float(np.clip(speed + 3 * np.asarray(action)[0].item() * DT, 0, 8))
        at += speed * DT
    assert speed < 0.1
    assert 15 < at < 30 - 2.5


def test_a_hidden_kerb_slows_a_car_that_expects_somebody_there():
    places = HiddenPlaces(column(12.0), column(2.5), column(4.0))
    seen, wary = scene(people((99, 20, 0, 0)), places=places), PeopleBelief(futures=8, emergence=0.3)
    assert best_pedal(replace(PLAIN, belief=replace(wary, emergence=0.0)), seen).item() == 1
    assert best_pedal(replace(PLAIN, belief=wary, contact_cost=100.0), seen).item() < 0


@pytest.mark.long
def test_it_keeps_the_contract_in_a_world_where_people_hide():
    street = Street.create(config=replace(WORLDS["blind-corner"], pedestrians=4, max_braking=6.0))
    driver = with_limits(BeliefPlanner(PeopleBelief(futures=2, hazard=0.1, emergence=0.1)), street.config)
    assert driver.max_braking == 6.0 and driver.kinds == street.config.kinds
    check_driver(driver, street, steps=2)
