"""What a table of collisions says, without a replay: who is replayed from where, labels and shares."""

from __future__ import annotations

import dataclasses
import json

import numpy as np

from jaxwalk.evaluation import Counterfactuals, summarise_counterfactuals
from jaxwalk.evaluation.counterfactual import find_hits
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
    defaults = {name: np.zeros(n, bool) for name in COLUMNS} | {"scenario": np.arange(n), "notice": np.ones(n)}
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
        "crosswalk": (1, 2), "wait": (1, 4), "brake": (1, 5), "planner": (1, 5), "planner_from_start": (5, 5)
    }  # fmt: skip
    assert summary.sidewalk.avoided["wait"].value is None
    document = json.loads(json.dumps(summary.as_dict(), allow_nan=False))
    assert document["jaywalk"]["labels"]["unavoidable"]["value"] == 0.5
    assert document["sidewalk"]["avoided"]["crosswalk"]["trials"] == 0


def test_no_collisions_no_shares():
    summary = summarise_counterfactuals(made(contact=np.zeros(0, int)))
    assert summary.replayed == 0
    assert summary.all.labels["driver"].value is None
