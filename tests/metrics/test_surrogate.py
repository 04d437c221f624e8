"""Surrogate safety on scenes whose numbers are worked out by hand, its invariances, and a plain reference."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxwalk.metrics import SURROGATES, Rows, measure, summarise
from jaxwalk.metrics.footprint import required_deceleration, time_to_collision
from jaxwalk.metrics.injury import monfort_mueller_fatal, monfort_mueller_mais3, rosen_sander_fatal
from jaxwalk.metrics.surrogate import Surrogates, surrogate_columns
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.sim_config import SimConfig
from metrics import reference
from metrics.scenes import DISC, Scene, Walk, changed, trajectory
from metrics.test_properties import few, trajectories

MEASURES = ("ttc", "exposed_time", "pet", "t2", "drac", "impact_speed", "relative_speed")
number = st.integers(-2000, 2000).map(lambda n: n / 100)  # (no numbers whose squares vanish)


def surrogates(scene: Scene) -> dict[str, float]:
    """Those of the scene's only encounter."""
    table = measure(trajectory(scene), config=DISC)[SURROGATES]
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


def test_the_car_may_come_5_s_later_but_no_more():
    # as before: at 1.28 m/s the car is at 18.64 m in frame 73, the pedestrian 0.6 m aside 50 frames before;
    # at 1.27 m/s no two places within 1.5 m are nearer in time than 51 frames
    walk = Walk(20, -4, vy=2, crossings=[(1, 39, CROSSWALK)])
    assert_measured(Scene(90, [walk], speed=[5.0] * 26 + [1.28] * 65), pet=5.0)
    assert_measured(Scene(90, [walk], speed=[5.0] * 26 + [1.27] * 65), pet=math.nan, t2=math.nan)


def test_a_car_that_comes_in_the_next_frame_is_second():
    # the pedestrian is 1.4 m aside in frame 27, the car at 13.5 m then and at 14 m, within 1.5 m, in the next frame
    scene = Scene(80, [Walk(14.5, -4, vy=2, crossings=[(1, 39, CROSSWALK)])])
    assert_measured(scene, pet=0.1, t2=0.1)


def test_who_stands_in_the_way_is_there_already():
    # the car is at 18.5 m in frame 37, not yet within 1.5 m, and at 19 m in frame 38
    scene = Scene(38, [Walk(20, 0, crossings=[(1, 38, JAYWALK)])], touched=[0])
    assert_measured(scene, pet=0, t2=0)


@pytest.mark.parametrize(("aside", "pet"), [(1.5, math.nan), (1.25, 0.0)])
def test_a_body_that_just_reaches_the_side_of_the_car_is_not_in_its_way(aside, pet):
    # the car is 2 m wide and the body's radius is 0.5 m: 1 + 0.5 m aside is the limit
    rules = SimConfig(car_length=4.0, car_width=2.0, body_radius=0.5)
    recorded = trajectory(Scene(60, [Walk(10, aside, crossings=[(1, 60, JAYWALK)])]))
    assert measure(recorded, config=rules)[SURROGATES].pet == pytest.approx([pet], nan_ok=True)


@pytest.mark.parametrize(("x", "exposed"), [(3.1, 0.0), (3.0, 0.1)])
def test_exposed_time_is_below_the_limit_and_not_at_it(x, exposed):
    # the car stands, and the pedestrian is at x - 0.1 in its only frame on the roadway: (3 - 1.5) / 1 s, or less
    assert_measured(Scene(5, [Walk(x, 0, vx=-1, crossings=[(1, 1, CROSSWALK)])], speed=0), exposed_time=exposed)


@pytest.mark.parametrize(("speed", "impact"), [(0.5, 0.5), (0.4, math.nan)])
def test_a_car_that_just_moves_hits(speed, impact):
    scene = Scene(9, [Walk(1, 0, crossings=[(1, 9, CROSSWALK)])], speed=speed, touched=[0])
    assert_measured(scene, impact_speed=impact, relative_speed=speed)


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


def deceleration(dx, dy, dvx, dvy, radius):
    """What discs need."""
    return required_deceleration(time_to_collision(dx, dy, dvx, dvy, radius), np.hypot(dvx, dvy))


def test_time_to_collision_by_hand():
    assert time_to_collision(2.0, 0.0, -0.1, 0.0, 1.5) == pytest.approx(5)
    # head-on, standing, in touch, parting, passing at 3 m, grazing at 1.5 m
    dx, dy = np.array([11.5, 5, 1, 5, 10, 10]), np.array([0, 0, 0, 0, 3, 1.5])
    dvx = np.array([-2.0, 0, 1, 1, -2, -2])
    assert time_to_collision(dx, dy, dvx, 0, 1.5).tolist() == [5, math.inf, 0, math.inf, math.inf, 5]
    assert deceleration(dx, dy, dvx, 0, 1.5) == pytest.approx([0.2, 0, math.nan, 0, 0, 0.2], nan_ok=True)


@given(number, number, number, number, st.floats(0.1, 10))
def test_scaling_lengths_scales_deceleration_and_leaves_times(dx, dy, dvx, dvy, radius):
    state = np.array([dx, dy, dvx, dvy, radius])
    assert time_to_collision(*(4 * state)) == pytest.approx(time_to_collision(*state))
    assert deceleration(*(4 * state)) == pytest.approx(4 * deceleration(*state), nan_ok=True)


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
    table = measure(recorded, config=DISC)[SURROGATES]
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
    before, after = (measure(t, config=DISC)[SURROGATES] for t in (recorded, changed(recorded, **turned)))
    for column in fields(before):
        np.testing.assert_allclose(getattr(before, column.name), getattr(after, column.name), rtol=1e-5)


def rows_of(episode, kind, **values) -> Rows:
    """Encounters with some measures; the others don't exist."""
    measures = {name: np.array(values.get(name, [np.nan] * len(kind)), float) for name in MEASURES}
    table = Surrogates(episode=np.array(episode), type=np.array(kind), **measures)
    return Rows(dt=0.1, episodes=max(episode) + 1, metrics=(SURROGATES,), tables={SURROGATES.name: table})


def test_shares_count_encounters_and_their_intervals_the_episodes_that_have_some():
    kinds = [CROSSWALK] * 6 + [JAYWALK]
    rows = rows_of([0, 1, 1, 2, 2, 2, 3], kinds, drac=[0] * 7, exposed_time=[0] * 7)
    found = summarise(rows, resamples=20)[SURROGATES]
    crosswalk, jaywalk = found.crosswalk.drac_critical, found.jaywalk.drac_critical
    assert (crosswalk.count, found.crosswalk.exposed_time.count, jaywalk.count) == (6, 6, 1)
    # none of n trials: the exact interval ends at 1 - 0.025^(1 / n); the trials are 3 episodes, and 1
    assert (crosswalk.high, jaywalk.high) == pytest.approx((1 - 0.025 ** (1 / 3), 0.975))


def test_intervals_of_impacts_end_where_speeds_and_risks_do():
    found = summarise(rows_of([0, 1], [CROSSWALK] * 2, impact_speed=[1, 40]), resamples=20)[SURROGATES].crosswalk
    assert (found.impact_speed.value, found.impact_speed.low) == (20.5, 0)
    assert [(risk.low, risk.high) for risk in (found.mais3, found.fatal, found.fatal_rosen_sander)] == [(0, 1)] * 3


def test_limits_are_not_beyond_themselves_and_any_lead_is_one():
    values = {"ttc": [1.5, 1.4, 9], "pet": [0.1, 3.0, -1.5], "drac": [3.4, 3.5, 0]}
    rows = rows_of([0, 0, 0], [CROSSWALK] * 3, **values)
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
    found = summarise(measure(trajectory(*scenes), config=DISC), resamples=200)[SURROGATES]
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
