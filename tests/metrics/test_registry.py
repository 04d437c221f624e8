"""A metric is one object: what it measures is in the rows, the summary and the document, with its types."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from jaxwalk.metrics import (
    ENCOUNTERS,
    METRICS,
    OUTCOMES,
    WAITING,
    Estimate,
    Metric,
    Recording,
    Rows,
    Summary,
    Sums,
    measure,
    summarise,
)
from jaxwalk.metrics.metric import Finding, with_needs
from jaxwalk.metrics.statistics import interval, ratio
from jaxwalk.sim.crossing_kind import JAYWALK
from metrics.scenes import Scene, Walk, ghosts_of, random_trajectory, trajectory


@dataclass(frozen=True)
class TopSpeeds:
    """One row per episode."""

    fastest: np.ndarray
    """[m/s]"""
    met: np.ndarray
    """Encounters."""


@dataclass(frozen=True)
class TopSpeed:
    """How fast cars were at most."""

    mean: Estimate
    """[m/s]"""
    per_encounter: Estimate
    """[m/s]"""


def _measure(recording: Recording) -> TopSpeeds:
    fastest = recording.trajectory.car_speed.max(axis=0)
    return TopSpeeds(fastest, np.bincount(recording[ENCOUNTERS].episode, minlength=len(fastest)))


def _columns(rows: Rows) -> dict[str, np.ndarray]:
    return {"fastest": rows[TOP_SPEED].fastest, "one": np.ones(rows.episodes)}


def _summarise(rows: Rows, sums: Sums) -> TopSpeed:
    fastest, met = sums[TOP_SPEED]["fastest"], sums[ENCOUNTERS]["encounters"].sum(axis=1)
    mean = interval(ratio(fastest, sums[TOP_SPEED]["one"]), rows.episodes)
    return TopSpeed(mean, interval(ratio(fastest, met), met[0]))


TOP_SPEED = Metric(
    name="top_speed",
    measure=_measure,
    needs=(ENCOUNTERS,),
    columns=_columns,
    summarise=_summarise,
)


@pytest.fixture(scope="module")
def recorded():
    crossing = Walk(12, 0, crossings=[(5, 8, JAYWALK)])
    return trajectory(Scene(9, [crossing], speed=4.0), Scene(9, [crossing], speed=6.0), Scene(9, [Walk(90, 50)]))


@pytest.fixture(scope="module")
def everything():
    world = random_trajectory(3, episodes=8, frames=20, people=3)
    return summarise(measure(world, ghosts_of(world)), resamples=20)


def test_a_new_metric_is_in_the_rows_the_summary_and_the_document(recorded):
    rows = measure(recorded, metrics=(*METRICS, TOP_SPEED))
    assert rows[TOP_SPEED].met.tolist() == [1, 1, 0]
    found = summarise(Rows.join([rows, rows]), resamples=20)
    assert (found[TOP_SPEED].mean.value, found[TOP_SPEED].per_encounter.value) == (5.0, 7.5)
    document = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert list(document)[-1] == "top_speed"
    assert (document["top_speed"]["per_encounter"]["value"], document["top_speed"]["per_encounter"]["count"]) == (
        7.5,
        4,
    )
    assert Summary.from_dict(document, metrics=(*METRICS, TOP_SPEED)) == found


def test_a_new_metric_leaves_the_others_alone(recorded):
    before, after = (summarise(measure(recorded, metrics=m), resamples=20) for m in (METRICS, (*METRICS, TOP_SPEED)))
    for name, numbers in before.as_dict().items():
        _assert_close(numbers, after.as_dict()[name])


@pytest.mark.parametrize("metric", METRICS, ids=lambda metric: metric.name)
def test_a_metric_says_all_that_it_needs(metric, everything):
    world = random_trajectory(3, episodes=8, frames=20, people=3)
    alone = summarise(measure(world, ghosts_of(world), metrics=[metric]), resamples=20)
    for name, numbers in alone.as_dict().items():
        _assert_close(numbers, everything.as_dict()[name])


def _assert_close(a, b):
    """Nested numbers agree but for rounding: where a column stands may change the last bit of its sum."""
    if isinstance(a, dict):
        assert a.keys() == b.keys()
        a, b = tuple(a.values()), tuple(b.values())
    if isinstance(a, tuple):
        for x, y in zip(a, b, strict=True):
            _assert_close(x, y)
    else:
        assert a == b or (a is not None and b is not None and math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12))


def test_what_is_not_among_the_needs_is_named(recorded):
    with pytest.raises(KeyError, match="encounters has not been measured"):
        measure(recorded, metrics=[replace(TOP_SPEED, needs=())])


def test_what_was_not_measured_is_named(recorded):
    rows = measure(recorded, metrics=[ENCOUNTERS])
    with pytest.raises(KeyError, match="waiting was not measured; there are crossings, encounters"):
        rows[WAITING]
    with pytest.raises(KeyError, match="waiting was not measured; there are encounters"):
        summarise(rows, resamples=5)[WAITING]


def test_rows_of_different_metrics_cannot_be_joined(recorded):
    parts = [measure(recorded, metrics=[metric]) for metric in (WAITING, TOP_SPEED)]
    with pytest.raises(ValueError, match="rows of different metrics cannot be joined"):
        Rows.join(parts)


def test_two_metrics_of_one_name_are_refused(recorded):
    with pytest.raises(ValueError, match="two metrics are named outcomes"):
        measure(recorded, metrics=[*METRICS, replace(TOP_SPEED, name="outcomes")])


def test_headlines_come_first(everything):
    assert list(everything.as_dict())[:5] == ["episodes", "outcomes", "speed_differential", "contacts", "attribution"]


def test_the_parts_of_a_metric_are_given_by_name():
    with pytest.raises(TypeError, match="positional"):
        Finding("top_speed", _measure)
    with pytest.raises(TypeError, match="positional"):
        Metric(_summarise, name="top_speed", measure=_measure)


def test_one_part_is_joined_to_itself(recorded):
    rows = measure(recorded, metrics=[ENCOUNTERS])
    joined = Rows.join([rows])
    assert (joined.episodes, joined.metrics) == (3, rows.metrics)
    assert joined[ENCOUNTERS].episode.tolist() == rows[ENCOUNTERS].episode.tolist() == [0, 1]


def test_needs_come_first():
    order = [finding.name for finding in with_needs(METRICS)]
    assert order.index("road") < order.index("crossings") < order.index("encounters") < order.index("outcomes")
    assert len(order) == len(set(order))


def test_a_document_gives_its_summary_again(everything):
    document = json.loads(json.dumps(everything.as_dict(), allow_nan=False))
    again = Summary.from_dict(document)
    assert again == everything
    assert again.as_dict() == everything.as_dict()
    assert list(again.as_dict()) == list(everything.as_dict())
    assert Summary.from_dict(everything.as_dict()) == everything
    assert again[OUTCOMES].goal == everything[OUTCOMES].goal


def _spoiled(document, *path, value=None):
    """The document with one part replaced, or removed if there is no value."""
    *way, last = path
    part = document
    for step in way:
        part = part[step]
    if value is None:
        del part[last]
    else:
        part[last] = value
    return document


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (["waiting"], None, "waiting: Field required"),
        (["episodes"], None, "episodes: Field required"),
        (["outcomes", "goal", "low"], None, "outcomes.goal.low: Field required"),
        (["speed_differential", 1, "near"], None, "speed_differential.1.near: Field required"),
        (["encounters", "bicycle"], {}, "encounters.bicycle: Unexpected keyword argument"),
        (["surprise"], {}, "surprise: Extra inputs are not permitted"),
        (["outcomes", "goal", "value"], "0.5", "outcomes.goal.value: Input should be a valid number"),
        (["outcomes", "goal", "trials"], 0.5, "outcomes.goal.trials: Input should be a valid integer"),
    ],
)
def test_a_part_that_is_unknown_or_missing_is_named(everything, path, value, message):
    document = json.loads(json.dumps(everything.as_dict()))
    with pytest.raises(ValueError, match=message):
        Summary.from_dict(_spoiled(document, *path, value=value))
