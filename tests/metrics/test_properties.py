"""What no metric may depend on: the order of people and episodes, batching, padding; and a plain reference."""

from __future__ import annotations

import json
import math
from dataclasses import fields, is_dataclass
from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxwalk import metrics
from jaxwalk.metrics import ENCOUNTERS, PLACEBO, SPEED_DIFFERENTIAL, Rows, measure, summarise
from jaxwalk.metrics.contacts import RULES
from jaxwalk.metrics.footprint import near_car
from jaxwalk.metrics.meetings import meeting_columns
from jaxwalk.sim import events
from jaxwalk.sim.sim_config import SimConfig
from metrics.reference import encounters, near_speeds
from metrics.scenes import ghosts_of, padded, pick, random_trajectory, turned

few = settings(max_examples=15, deadline=None)
trajectories = st.builds(
    random_trajectory,
    st.integers(0, 2**32 - 1),
    episodes=st.integers(1, 4),
    frames=st.integers(2, 30),
    people=st.integers(1, 4),
)


def assert_same(a, b):
    """Nested dicts and tuples of numbers and None agree."""
    assert type(a) is type(b)
    if isinstance(a, dict):
        assert a.keys() == b.keys()
        for key in a:
            assert_same(a[key], b[key])
    elif isinstance(a, tuple):
        assert len(a) == len(b)
        for left, right in zip(a, b, strict=True):
            assert_same(left, right)
    else:
        assert a == b or (a is not None and b is not None and math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12))


def assert_equal_rows(a: Rows, b: Rows):
    assert (a.dt, a.episodes, a.metrics, a.tables.keys()) == (b.dt, b.episodes, b.metrics, b.tables.keys())
    for name, left in a.tables.items():
        right = b.tables[name]
        for column in fields(left):
            # (sums may be grouped differently: hence a tolerance)
            a_column, b_column = getattr(left, column.name), getattr(right, column.name)
            np.testing.assert_allclose(a_column, b_column, rtol=1e-12, err_msg=column.name)
            assert a_column.dtype == b_column.dtype


@pytest.mark.parametrize("module", [name for _, name, _ in iter_modules(metrics.__path__)])
def test_nobody_changes_what_was_measured(module):
    found = vars(import_module(f"{metrics.__name__}.{module}")).values()
    own = [x for x in found if is_dataclass(x) and x.__module__.endswith(f".{module}")]
    assert [x for x in own if not x.__dataclass_params__.frozen] == []


@pytest.mark.long
@few
@given(trajectories, st.randoms(use_true_random=False))
def test_the_order_of_pedestrians_does_not_matter(recorded, random):
    order = list(range(recorded.ped_x.shape[2]))
    random.shuffle(order)
    before, after = (summarise(measure(t), resamples=20) for t in (recorded, pick(recorded, people=order)))
    assert_same(before.as_dict(), after.as_dict())
    json.dumps(after.as_dict(), allow_nan=False)


@few
@given(trajectories, st.randoms(use_true_random=False))
def test_the_order_of_episodes_does_not_matter(recorded, random):
    order = list(range(len(recorded.length)))
    random.shuffle(order)
    before, after = (summarise(measure(t), resamples=0) for t in (recorded, pick(recorded, episodes=order)))
    assert_same(before.as_dict(), after.as_dict())


@few
@given(trajectories, st.integers(0, 4), st.integers(0, 4))
def test_joined_rows_of_parts_are_the_rows_of_the_whole(recorded, cut, size):
    parts = [pick(recorded, episodes=slice(*ends)) for ends in ((0, cut), (cut, cut + size), (cut + size, None))]
    assert_equal_rows(Rows.join([measure(part) for part in parts]), measure(recorded))


@few
@given(trajectories, st.integers(1, 5))
def test_padding_is_not_seen(recorded, frames):
    assert_equal_rows(measure(padded(recorded, frames)), measure(recorded))


@few
@given(trajectories)
def test_encounters_agree_with_the_reference(recorded):
    table = measure(recorded)[ENCOUNTERS]
    names = ("episode", "ped", "number", "type", "enter", "start", "end", "min_distance", "braking", "braking_time")
    rows = list(zip(*(getattr(table, name) for name in names), strict=True))
    expected = encounters(recorded)
    assert len(rows) == len(expected)
    for row, reference in zip(rows, expected, strict=True):
        assert [float(v) for v in row] == pytest.approx([float(v) for v in reference], rel=1e-6, nan_ok=True)


@few
@given(trajectories)
def test_near_speeds_agree_with_the_reference(recorded):
    rows = measure(recorded)
    meetings = meeting_columns(rows)
    pairs = (
        (rows[SPEED_DIFFERENTIAL].frames, rows[SPEED_DIFFERENTIAL].speed_sum),
        (meetings["meetings"], meetings["meeting_speed"]),
    )
    for (count, total), reference in zip(pairs, near_speeds(recorded), strict=True):
        assert count.sum() == sum(len(v) for v in reference.values())
        for (episode, kind, place), speeds in reference.items():
            assert count[episode, kind - 1, place] == len(speeds)
            assert total[episode, kind - 1, place] == pytest.approx(sum(speeds))


@few
@given(trajectories, st.integers(1, 3))
def test_a_turned_scene_gives_the_same_numbers(recorded, quarters):
    before, after = (summarise(measure(t), resamples=20) for t in (recorded, turned(recorded, quarters)))
    assert_same(before.as_dict(), after.as_dict())


@few
@given(trajectories)
def test_ghosts_who_are_the_people_themselves_make_no_difference(recorded):
    rows = measure(recorded, ghosts_of(recorded), config=SimConfig(collision_distance=1e-3))
    np.testing.assert_array_equal(rows[PLACEBO].frames, rows[PLACEBO].ghost_frames)
    np.testing.assert_array_equal(rows[PLACEBO].speed_sum, rows[PLACEBO].ghost_speed_sum)
    assert (rows[PLACEBO].frames <= rows[SPEED_DIFFERENTIAL].frames).all()


@few
@given(trajectories, st.sampled_from(RULES))
def test_whoever_is_touched_is_near(recorded, contact):
    rules = SimConfig(contact=contact, collision_distance=3.0)
    places = [(frame, e, p) for e, p, frame in np.ndindex(*np.roll(recorded.ped_x.shape, -1))]
    touched = [place for place in places if place[0] <= recorded.length[place[1]] and touches(recorded, place, rules)]
    near = [tuple(place) for place in np.stack(near_car(recorded, rules), axis=1).tolist()]
    assert near == [place for place in places if place in set(near)]  # by episode, pedestrian and frame
    assert set(touched) <= set(near)


def touches(recorded, place, rules):
    car = place[:2]
    dx, dy = recorded.ped_x[place] - recorded.car_x[car], recorded.ped_y[place] - recorded.car_y[car]
    return events.touching(rules, dx, dy, recorded.car_cos[car], recorded.car_sin[car])
