"""Surrogate safety on scenes whose numbers are worked out by hand, its invariances, and a plain reference."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxwalk.metrics import SURROGATES, Rows, measure, summarise
from jaxwalk.metrics.injury import monfort_mueller_fatal, monfort_mueller_mais3, rosen_sander_fatal
from jaxwalk.metrics.surrogate import Surrogates, required_deceleration, surrogate_columns, time_to_collision
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics import reference
from metrics.scenes import Scene, Walk, changed, trajectory
from metrics.test_properties import few, trajectories

MEASURES = ("ttc", "exposed_time", "pet", "t2", "drac", "impact_speed", "relative_speed")
number = st.integers(-2000, 2000).map(lambda n: n / 100)  # (no numbers whose squares vanish)


def surrogates(scene: Scene) -> dict[str, float]:
    """Those of the scene's only encounter."""
    table = measure(trajectory(scene))[SURROGATES]
    assert len(table.episode) == 1
    return {name: float(getattr(table, name)[0]) for name in MEASURES}


def assert_measured(scene: Scene, **expected: float):
    measured = surrogates(scene)
    assert {name: measured[name] for name in expected} == pytest.approx(expected, nan_ok=True, rel=1e-5, abs=1e-6)


def test_head_on_with_a_car_that_never_brakes():
    # 30 - 0.6 k m apart, nearing at 6 m/s: TTC below 1.5 s from 10.5 m on (frames 33 to 48), 0.3 m / 6 m/s in frame 47
    walk = Walk(30, 0, vx=-1, crossings=[(3, 48, JAYWALK)])
    scene = Scene(48, [walk], touched=[0])
    assert_measured(scene, ttc=0, exposed_time=1.6, pet=0, t2=0, drac=60, impact_speed=5, relative_speed=6)


def test_head_on_until_the_car_stops():
    # 6 m/s until frame 20 (18.6 m apart), then the car stands: TTC (18.6 + 0.6 - 1.5) / 6, DRAC 36 / (2 * 17.7)
    walk = Walk(30.6, 0, vx=-1, crossings=[(3, 40, CROSSWALK)])
    scene = Scene(60, [walk], speed=[5.0] * 20 + [0.0] * 41)
    assert_measured(scene, ttc=(19.2 - 1.5) / 6, exposed_time=0, drac=36 / (2 * 17.7), impact_speed=math.nan)


def test_pedestrian_crosses_before_the_car():
    # car at 0.5 j, pedestrian 20 m ahead at 0.2 k - 4: the nearest frames within 1.5 m are k = 27 and j = 39
    scene = Scene(80, [Walk(20, -4, vy=2, crossings=[(1, 39, CROSSWALK)])])
    assert_measured(scene, pet=1.2, t2=1.2, ttc=math.nan, drac=0, exposed_time=0, relative_speed=math.nan)


def test_pedestrian_crosses_behind_the_car():
    # car at 0.5 j, pedestrian 10 m ahead at 0.1 k - 4: the nearest frames within 1.5 m are j = 21 and k = 26
    scene = Scene(80, [Walk(10, -4, vy=1, crossings=[(1, 60, CROSSWALK)])])
    assert_measured(scene, pet=-0.5, t2=0.5, ttc=math.nan, drac=0)


def test_a_car_that_comes_more_than_5_s_later_shares_no_conflict():
    # car at 12.5 + 0.134 (j - 25), pedestrian as before: of places within 1.5 m, k = 25 and j = 73 are nearest in time
    walk = Walk(20, -4, vy=2, crossings=[(1, 39, CROSSWALK)])
    assert_measured(Scene(90, [walk], speed=[5.0] * 26 + [1.34] * 65), pet=4.8)
    assert_measured(Scene(120, [walk], speed=[5.0] * 26 + [1.25] * 95), pet=math.nan)


def test_the_pedestrian_may_leave_the_roadway_before_the_car_arrives():
    scene = Scene(80, [Walk(20, -4, vy=2, crossings=[(1, 28, CROSSWALK)])])
    assert_measured(scene, pet=1.2, t2=1.2)


def test_t2_sees_the_car_that_yields_before_pet_does():
    # as above, but after frame 25 (12.5 m) the car crawls, and comes too late for a PET
    speed = [5.0] * 26 + [1.0] * 100
    late = Scene(80, [Walk(20, -4, vy=2, crossings=[(1, 39, CROSSWALK)])], speed=speed[:81])
    assert_measured(late, pet=math.nan, t2=math.nan)
    # at 2 m/s it is at 18.9 m in frame 57, 32 after the pedestrian (1 m beyond the middle); seen at 5 m/s from 12.5 m
    speed = [5.0] * 26 + [2.0] * 55
    yields = Scene(80, [Walk(20, -4, vy=2, crossings=[(1, 39, CROSSWALK)])], speed=speed)
    assert_measured(yields, pet=3.2, t2=(18.9 - 12.5) / 5)


def test_a_standing_car():
    walk = Walk(3, -4, vy=1, crossings=[(1, 80, CROSSWALK)])
    nothing = {"pet": math.nan, "t2": math.nan, "ttc": math.nan, "drac": 0, "impact_speed": math.nan}
    assert_measured(Scene(80, [walk], speed=0), **nothing)


def test_who_walks_into_a_standing_car_was_not_hit_by_it():
    walk = Walk(10, 0, vx=-1, crossings=[(1, 86, JAYWALK)])
    scene = Scene(86, [walk], speed=0, touched=[0])
    assert_measured(scene, ttc=0, pet=0, impact_speed=math.nan, relative_speed=1)


def test_parallel_paths_never_meet():
    scene = Scene(40, [Walk(10, 3, vx=1, crossings=[(1, 40, CROSSWALK)])])
    assert_measured(scene, pet=math.nan, t2=math.nan, ttc=math.nan, drac=0, exposed_time=0)


def test_time_to_collision_by_hand():
    assert time_to_collision(2.0, 0.0, -0.1, 0.0, 1.5) == pytest.approx(5)
    # head-on, standing, in touch, parting, passing at 3 m, grazing at 1.5 m
    dx, dy = np.array([11.5, 5, 1, 5, 10, 10]), np.array([0, 0, 0, 0, 3, 1.5])
    dvx = np.array([-2.0, 0, 1, 1, -2, -2])
    assert time_to_collision(dx, dy, dvx, 0, 1.5).tolist() == [5, math.inf, 0, math.inf, math.inf, 5]
    deceleration = required_deceleration(dx, dy, dvx, 0, 1.5)
    assert deceleration == pytest.approx([0.2, 0, math.nan, 0, 0, 0.2], nan_ok=True)


@given(number, number, number, number, st.floats(0.1, 10))
def test_scaling_lengths_scales_deceleration_and_leaves_times(dx, dy, dvx, dvy, radius):
    state = np.array([dx, dy, dvx, dvy, radius])
    assert time_to_collision(*(4 * state)) == pytest.approx(time_to_collision(*state))
    assert required_deceleration(*(4 * state)) == pytest.approx(4 * required_deceleration(*state), nan_ok=True)


@given(number, number, number, number, st.floats(0.1, 10))
def test_discs_touch_at_the_time_to_collision_and_not_before(dx, dy, dvx, dvy, radius):
    ttc = time_to_collision(*np.array([dx, dy, dvx, dvy, radius]))
    if not 0 < ttc < 1e6:
        return
    assert math.hypot(dx + dvx * ttc, dy + dvy * ttc) == pytest.approx(radius, rel=1e-6, abs=1e-6)
    assert math.hypot(dx + dvx * ttc / 2, dy + dvy * ttc / 2) > radius * (1 - 1e-6)


@few
@given(trajectories)
def test_surrogates_agree_with_the_reference(recorded):
    table = measure(recorded)[SURROGATES]
    rows = list(zip(*(getattr(table, name) for name in MEASURES), strict=True))
    expected = reference.surrogates(recorded)
    assert len(rows) == len(expected)
    for row, values in zip(rows, expected, strict=True):
        assert [float(v) for v in row] == pytest.approx(values, rel=1e-5, abs=1e-6, nan_ok=True)


@few
@given(trajectories)
def test_turning_the_scene_by_90_degrees_changes_nothing(recorded):
    pairs = (("car_x", "car_y"), ("car_cos", "car_sin"), ("ped_x", "ped_y"), ("ped_vx", "ped_vy"))
    turned = {x: -getattr(recorded, y) for x, y in pairs} | {y: getattr(recorded, x) for x, y in pairs}
    before, after = (measure(t)[SURROGATES] for t in (recorded, changed(recorded, **turned)))
    for column in fields(before):
        np.testing.assert_allclose(getattr(before, column.name), getattr(after, column.name), rtol=1e-5)


def test_limits_are_not_beyond_themselves_and_any_lead_is_one():
    values = {"ttc": [1.5, 1.4, 9], "pet": [0.1, 3.0, -1.5], "drac": [3.4, 3.5, 0]}
    rest = {name: np.full(3, np.nan) for name in MEASURES if name not in values}
    kinds = {"episode": np.zeros(3, int), "type": np.full(3, CROSSWALK)}
    table = Surrogates(**kinds, **{name: np.array(x, float) for name, x in values.items()}, **rest)
    rows = Rows(dt=0.1, episodes=1, metrics=(SURROGATES,), tables={SURROGATES.name: table})
    found = {name: x[0, 0] for name, x in surrogate_columns(rows).items()}
    counts = {"met": 3, "ttc_critical": 1, "pet_critical": 1, "pet_close": 2, "drac_critical": 1}
    assert {name: found[name] for name in counts} == counts
    assert (found["pedestrian_first"], found["one_first"]) == (2, 3)


def test_summary():
    crossing = [(1, 39, CROSSWALK)]
    scenes = [
        Scene(80, [Walk(20, -4, vy=2, crossings=crossing)]),  # PET 1.2 s
        Scene(80, [Walk(20, -4, vy=2, crossings=crossing)], speed=[5.0] * 26 + [2.0] * 55),  # PET 3.2 s
        Scene(80, [Walk(10, -4, vy=1, crossings=crossing)]),  # PET -0.5 s
        Scene(48, [Walk(30, 0, vx=-1, crossings=[(3, 48, CROSSWALK)])], touched=[0]),  # hit at 5 m/s
    ]
    found = summarise(measure(trajectory(*scenes)), resamples=200)[SURROGATES]
    here = found.crosswalk
    shares = (here.ttc_critical, here.drac_critical, here.pet_critical, here.pet_close)
    assert [share.value for share in shares] == [0.25, 0.25, 0.75, 0.75]
    assert [share.count for share in shares] == [4, 4, 4, 4]
    assert here.pedestrian_first.value == pytest.approx(2 / 3)
    assert here.pet.median.value == pytest.approx((0.5 + 1.2) / 2)
    assert (here.ttc.median.count, here.drac.median.count, here.pet.median.count) == (1, 4, 4)
    assert here.exposed_time.value == pytest.approx(0.4)
    assert (here.impact_speed.value, here.impact_speed.count) == (5, 1)
    assert here.mais3.value == pytest.approx(monfort_mueller_mais3(5))
    assert here.fatal.value == pytest.approx(monfort_mueller_fatal(5))
    assert here.fatal_rosen_sander.value == pytest.approx(rosen_sander_fatal(5))
    nobody = found.jaywalk
    assert (nobody.count, nobody.ttc_critical.value, nobody.pet.median.value, nobody.mais3.value) == (
        0,
        None,
        None,
        None,
    )
