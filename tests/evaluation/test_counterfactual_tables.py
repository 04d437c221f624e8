"""What a table of collisions says, without a replay: who is replayed from where, labels and shares."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.evaluation import Counterfactuals, summarise_counterfactuals
from jaxwalk.evaluation.counterfactual import first_seen_frame
from jaxwalk.evaluation.hits import find_hits
from jaxwalk.metrics import measure
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, trajectory

COLUMNS = [field.name for field in dataclasses.fields(Counterfactuals) if field.name != "collisions"]


def test_when_the_change_begins():
    crossing = Walk(0, 0, crossings=[(2, 5, JAYWALK), (20, 40, JAYWALK)])
    from_the_start = Walk(0, 0, crossings=[(0, 40, CROSSWALK)])
    beside = Walk(0, 0, crossings=[(3, 9, CROSSWALK)])
    scenes = [
        Scene(40, [beside, crossing], touched=[1]),
        Scene(40, [crossing, from_the_start], touched=[1]),
        Scene(40, [crossing, beside], touched=[1]),
        Scene(20, [beside, beside], touched=[0]),
        Scene(40, [crossing, beside], goal=True),
    ]
    hits = find_hits(measure(trajectory(*scenes, scenario=[5, 6, 7, 8, 9])))
    assert hits.scenario.tolist() == [5, 6, 7, 8]
    assert hits.contact.tolist() == [JAYWALK, CROSSWALK, 3, 3]
    assert hits.ped.tolist() == [1, 1, 1, 0]
    assert hits.start.tolist() == [20, 0, 10, 0]
    assert hits.entered.tolist() == [True, False, False, False]


def made(**columns):
    n = len(columns["contact"])
    defaults = {name: np.zeros(n, bool) for name in COLUMNS} | {"scenario": np.arange(n)}
    defaults |= {"notice": np.ones(n), "seen_for": np.ones(n)}
    return Counterfactuals(collisions=9, **defaults | {name: np.array(x) for name, x in columns.items()})


def test_labels_and_shares():
    found = made(
        contact=[1, 1, 2, 2, 3],
        crosswalk_applies=[False, False, True, True, False],
        wait_applies=[True, True, True, True, False],
        crosswalk=[False, False, True, False, False],
        wait=[True, False, False, False, False],
        brake=[True, False, False, False, False],
        planner=[False, True, False, False, False],
        planner_from_start=[True, True, True, True, True],
    )
    assert found.label.tolist() == ["either", "driver", "pedestrian", "unavoidable", "unavoidable"]
    summary = summarise_counterfactuals(found)
    assert (summary.collisions, summary.replayed, summary.jaywalk.collisions) == (9, 5, 2)
    assert {label: rate.successes for label, rate in summary.all.labels.items()} == {
        "either": 1, "driver": 1, "pedestrian": 1, "unavoidable": 2
    }  # fmt: skip
    shares = {change: (rate.successes, rate.trials) for change, rate in summary.all.avoided.items()}
    assert shares == {
        "crosswalk": (1, 2), "wait": (1, 4), "brake": (1, 5), "planner": (1, 5), "planner_from_start": (5, 5),
        "human_when_seen": (0, 5), "human_from_start": (0, 5), "brake_when_seen": (0, 5), "planner_when_seen": (0, 5),
    }  # fmt: skip
    assert summary.sidewalk.avoided["wait"].value is None
    document = json.loads(json.dumps(summary.as_dict(), allow_nan=False))
    assert document["jaywalk"]["labels"]["unavoidable"]["value"] == 0.5
    assert document["sidewalk"]["avoided"]["crosswalk"]["trials"] == 0


def test_who_would_have_avoided_it_in_the_cars_place():
    found = made(
        contact=[1, 1, 2, 2, 3],
        moving=[True, True, True, False, True],
        human_when_seen=[True, True, False, False, False],
        human_from_start=[True, False, False, False, True],
        planner_when_seen=[True, False, True, False, False],
        brake_when_seen=[False, False, False, True, False],
        planner_from_start=[True, True, True, False, True],
        seen_for=[1.0, 2.0, 3.0, 4.0, 9.0],
    )
    assert found.judged.tolist() == ["human", "human", "oracle", "oracle", "unavoidable"]
    assert found.judged_from_start.tolist() == ["human", "oracle", "oracle", "unavoidable", "human"]
    summary = summarise_counterfactuals(found)
    assert counts(summary.all.judged) == (2, 2, 1)
    assert counts(summary.all.judged_from_start) == (2, 2, 1)
    assert counts(summary.moving.judged) == (2, 1, 1)
    assert counts(summary.jaywalk.judged_from_start) == (0, 1, 1)
    assert summary.all.seen_for.value == 3.0
    assert summary.preventable == summary.all.judged.human
    # Clopper and Pearson's interval of 2 in 5
    assert (summary.preventable.low, summary.preventable.high) == pytest.approx((0.0527, 0.8534), abs=1e-4)


def counts(judged):
    return tuple(rate.successes for rate in vars(judged).values())


def test_the_first_moment_in_which_somebody_is_seen(street):
    """The eye is 1.25 m before the car's centre, which drives at 5 m/s, and it sees for 60 m."""
    ahead, near = Walk(62.0, 0.0), Walk(3.0, 0.0)
    sees = trajectory(*[Scene(40, [ahead, near], touched=[k]) for k in (0, 1, 0)])
    hits = find_hits(measure(sees))
    assert first_seen_frame(street, sees, hits.ped, hits.steps).tolist() == [2, 0, 2]  # 0.75 m in 2 steps of 0.5 m
    perceived = np.zeros((41, 3, 2), bool)
    perceived[7, 0, 0] = perceived[30:, 0, 0] = True  # seen, hidden, and seen again
    perceived[5, 0, 1] = True
    perceived[40, 2, 0] = True
    hidden = replace(sees, perceived=perceived)
    assert first_seen_frame(street, hidden, hits.ped, hits.steps).tolist() == [7, 40, 40], (
        "who is never seen is seen at the contact"
    )


def test_no_collisions_no_shares():
    summary = summarise_counterfactuals(made(contact=np.zeros(0, int)))
    assert summary.replayed == 0
    assert summary.all.labels["driver"].value is None
    assert summary.preventable.value is None and summary.all.seen_for.value is None
