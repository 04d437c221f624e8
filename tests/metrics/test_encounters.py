"""Encounters and braking on scenes whose numbers are worked out by hand."""

from __future__ import annotations

import math

import pytest

from jaxwalk.metrics import CROSSINGS, ENCOUNTERS, measure, summarise
from jaxwalk.metrics.braking import ALREADY, NEVER, ONSET, STANDING, UNSEEN
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, changed, trajectory


def encountered(scene: Scene):
    return measure(trajectory(scene))[ENCOUNTERS]


def test_head_on():
    # 30 m apart, nearing at 5 + 1 m/s, 0.6 m per frame: 20 m is passed in frame 17, 1.5 m in frame 48 (30 - 28.8)
    walk = Walk(30, 0, vx=-1, crossings=[(3, 48, JAYWALK)])
    table = encountered(Scene(48, [walk], touched=[0]))
    assert [c.tolist() for c in (table.enter, table.start, table.end)] == [[3], [17], [48]]
    assert (table.min_distance, table.min_gap) == (pytest.approx([1.2]), pytest.approx([0]))
    assert (table.type[0], table.number[0], table.entry_speed[0], table.collided[0]) == (JAYWALK, 1, 5.0, True)


def test_crossing_in_front():
    # d^2 = 0.25 (40 - k)^2 + 0.04 (k - 20)^2: 20.4 m in frame 0, 19.9 m in frame 1, least in frame 37: 2.25 + 11.56
    walk = Walk(20, -4, vy=2, crossings=[(1, 39, CROSSWALK)])
    table = encountered(Scene(80, [walk]))
    assert [c.tolist() for c in (table.enter, table.start, table.end)] == [[1], [1], [39]]
    assert table.min_distance == pytest.approx(math.sqrt(13.81))
    assert not table.collided[0]


def test_the_smallest_distance_counts_only_on_the_roadway():
    # as above, but the pedestrian is off the roadway after frame 30: 0.25 * 100 + 0.04 * 100
    table = encountered(Scene(80, [Walk(20, -4, vy=2, crossings=[(1, 30, CROSSWALK)])]))
    assert table.min_distance == pytest.approx(math.sqrt(29))


def test_crossing_behind_the_car_is_a_crossing_but_no_encounter():
    rows = measure(trajectory(Scene(40, [Walk(-5, -4, vy=2, crossings=[(1, 39, JAYWALK)])])))
    assert len(rows[CROSSINGS].episode) == 1
    assert len(rows[ENCOUNTERS].episode) == 0


def test_a_car_beyond_20_m_is_no_encounter():
    assert len(encountered(Scene(18, [Walk(30, 0, crossings=[(1, 18, JAYWALK)])])).episode) == 0  # 21 m at the end
    assert encountered(Scene(20, [Walk(30, 0, crossings=[(1, 20, JAYWALK)])])).start == [20]  # 20 m at the end


def test_a_standing_pair_is_no_encounter():
    assert len(encountered(Scene(20, [Walk(10, 0, crossings=[(1, 20, CROSSWALK)])], speed=0)).episode) == 0


def test_two_crossings_of_one_pedestrian_are_two_encounters():
    walk = Walk(60, 0, crossings=[(85, 90, CROSSWALK), (100, 104, JAYWALK)])
    table = encountered(Scene(150, [walk]))
    assert [c.tolist() for c in (table.number, table.type)] == [[1, 2], [CROSSWALK, JAYWALK]]
    assert [c.tolist() for c in (table.start, table.end)] == [[85, 100], [90, 104]]
    assert table.min_distance == pytest.approx([15, 8])  # at 0.5 m per frame the car is at 45 and at 52 m


def test_only_the_last_crossing_of_who_was_hit_collided():
    walk = Walk(30, 0, vx=-1, crossings=[(20, 30, CROSSWALK), (40, 48, CROSSWALK)])
    assert encountered(Scene(48, [walk, Walk(9, 9)], touched=[0])).collided.tolist() == [False, True]


def test_a_crossing_under_way_at_the_end():
    rows = measure(trajectory(Scene(20, [Walk(20, 0, crossings=[(5, 99, JAYWALK)])]), Scene(30, [Walk(99, 0)])))
    assert (rows[CROSSINGS].last.tolist(), rows[CROSSINGS].completed.tolist()) == ([20], [False])
    assert (rows[ENCOUNTERS].end.tolist(), rows[ENCOUNTERS].min_distance.tolist()) == ([20], [10.0])
    assert rows[ENCOUNTERS].collided.tolist() == [False]


def test_a_crossing_that_ends_in_the_last_frame_but_one_is_complete():
    crossings = measure(trajectory(Scene(20, [Walk(20, 0, crossings=[(5, 19, JAYWALK)])])))[CROSSINGS]
    assert crossings.completed.tolist() == [True]


def test_who_goes_on_where_another_ended_begins_a_crossing_of_their_own():
    people = [Walk(9, 0, crossings=[(1, 3, CROSSWALK)]), Walk(9, 3, crossings=[(4, 6, CROSSWALK)])]
    later = [Walk(9, 0), Walk(9, 3, crossings=[(7, 8, CROSSWALK)])]
    crossings = measure(trajectory(Scene(9, people), Scene(9, later)))[CROSSINGS]
    assert [c.tolist() for c in (crossings.episode, crossings.ped)] == [[0, 0, 1], [0, 1, 1]]
    assert [c.tolist() for c in (crossings.enter, crossings.last)] == [[1, 4, 7], [3, 6, 8]]
    assert crossings.entry_seen.tolist() == [True, True, True]


def test_nobody_decided_the_place_tells_the_type():
    people = [Walk(9, 0, crossings=[(0, 9, CROSSWALK)]), Walk(9, 3, crossings=[(0, 9, JAYWALK)])]
    recorded = trajectory(Scene(9, people))
    rows = measure(changed(recorded, crossing=recorded.crossing * 0, decisions=recorded.decisions * 0))
    assert rows[CROSSINGS].type.tolist() == [CROSSWALK, JAYWALK]
    assert rows[CROSSINGS].entry_seen.tolist() == [False, False]


def scene(*, commands: dict[int, float], speed: float = 5.0, enter: int = 5, last: int = 25, length: int = 60) -> Scene:
    """A car and somebody standing ahead on the roadway from frame ``enter`` to ``last``."""
    walk = Walk(30, 0, crossings=[(enter, last, CROSSWALK)])
    return Scene(length, [walk], x=10.0, speed=speed, acceleration=commands)


@pytest.mark.parametrize(
    ("case", "status", "seconds"),
    [
        # commands of frames 12, 13, 14 are given in view of frames 11, 12, 13: 6 frames after the entry
        (scene(commands={12: -1, 13: -2, 14: -1}), ONSET, 0.6),
        # the first command that can answer the entry: at once
        (scene(commands={6: -3, 7: -3, 8: -3}), ONSET, 0.0),
        # two frames are not 0.3 s, nor is -0.99 m/s2 braking; the next is
        (scene(commands={8: -3, 9: -3, 10: -0.99, 20: -3, 21: -3, 22: -3}), ONSET, 1.4),
        # held beyond the end of the crossing, begun within
        (scene(commands={25: -3, 26: -3, 27: -3}), ONSET, 1.9),
        # begun after it, or cut short by the end of the episode: never; watched from frame 5 to 25
        (scene(commands={26: -3, 27: -3, 28: -3}), NEVER, 2.0),
        (scene(commands={24: -3, 25: -3}, length=25), NEVER, 2.0),
        (scene(commands={}), NEVER, 2.0),
        # braking that covers the step of the entry
        (scene(commands={3: -3, 4: -3, 5: -3}), ALREADY, math.nan),
        (scene(commands={5: -3, 6: -3, 7: -3}), ALREADY, math.nan),
        (scene(commands={2: -3, 3: -3, 4: -3}), NEVER, 2.0),
        # there is no command before the start
        (scene(commands={1: -3, 2: -3, 3: -3}, enter=2), ALREADY, math.nan),
        (scene(commands={1: -3, 2: -3}, enter=2), NEVER, 2.3),
        (scene(commands={0: -3, 1: -3, 2: -3}, enter=2), NEVER, 2.3),
        (scene(commands={12: -3, 13: -3, 14: -3}, speed=1.0), STANDING, math.nan),
        (scene(commands={12: -3, 13: -3, 14: -3}, speed=1.1), ONSET, 0.6),
        (scene(commands={12: -3, 13: -3, 14: -3}, enter=0), UNSEEN, math.nan),
    ],
)
def test_braking(case, status, seconds):
    table = encountered(case)
    assert table.braking.tolist() == [status]
    assert table.braking_time == pytest.approx([seconds], nan_ok=True)


@pytest.mark.parametrize(("dt", "status"), [(0.3, ONSET), (0.2, NEVER)])
def test_one_command_may_last_long_enough(dt, status):
    table = measure(changed(trajectory(scene(commands={12: -3})), dt=dt))[ENCOUNTERS]
    assert table.braking.tolist() == [status]


@pytest.mark.parametrize("slow", [0.8, 1.0])
def test_braking_of_a_car_that_has_become_slow_does_not_count(slow):
    speed = [5.0] * 10 + [slow] * 51
    walk, commands = Walk(14, 0, crossings=[(5, 25, CROSSWALK)]), dict.fromkeys(range(12, 18), -3)
    assert encountered(Scene(60, [walk], speed=speed, acceleration=commands)).braking.tolist() == [NEVER]


def test_summary_of_braking_keeps_those_who_never_brake():
    cases = [
        scene(commands={k: -3 for k in (8, 9, 10)}),  # 0.2 s
        scene(commands={k: -3 for k in (16, 17, 18)}),  # 1.0 s
        scene(commands={}),
        scene(commands={4: -3, 5: -3, 6: -3}),
        scene(commands={}, speed=0.5, last=59),
    ]
    braking = summarise(measure(trajectory(*cases)), resamples=50)[ENCOUNTERS].crosswalk.braking
    counts = (braking.observed, braking.censored, braking.already, braking.standing, braking.unseen)
    assert counts == (2, 1, 1, 1, 0)
    # survival 1 -> 2/3 at 0.2 s -> 1/3 at 1.0 s
    assert (braking.median.value, braking.median.count) == (pytest.approx(1.0), 3)
    assert braking.mean_observed.value == pytest.approx(0.6)
    nobody = summarise(measure(trajectory(*cases)), resamples=50)[ENCOUNTERS].jaywalk
    assert (nobody.count, nobody.collided.value, nobody.minimum_approach.value) == (0, None, None)
    assert (nobody.braking.median.value, nobody.braking.mean_observed.value) == (None, None)


def test_minimum_approach_is_the_5th_percentile():
    # people standing at the roadside 2, 3, 4, 5, 6 m off the path of a car that passes them: linear, 2 + 0.05 * 4
    people = [Walk(10, y, crossings=[(1, 40, JAYWALK)]) for y in (2, 3, 4, 5, 6)]
    found = summarise(measure(trajectory(Scene(40, people))), resamples=0)[ENCOUNTERS].jaywalk
    assert (found.minimum_approach.value, found.minimum_approach.count) == (pytest.approx(2.2), 5)
    # half of the car's 1.8 m and the body's 0.25 m are less
    assert (found.minimum_gap.value, found.minimum_gap.count) == (pytest.approx(2.2 - 1.15), 5)
