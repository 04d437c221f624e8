"""The sweep over the paper's free weights, very small: what is changed, what is judged, and what is said."""

import io
import json
from dataclasses import replace
from functools import partial

import pytest
from rich.console import Console

from jaxwalk.evaluation import evaluate_grid
from jaxwalk.experiments import tournament
from jaxwalk.experiments.paper_weights import SweepEffort, paper_weights, weights
from jaxwalk.recipes import RECIPES

PAPER = RECIPES["paper"]
PLAN = SweepEffort(updates=2, episodes=8, seed=3)
NAMES = ["as-it-is", "caution-x5", "caution-x10", "progress-x2", "bonus-anywhere"]


def test_one_weight_is_changed_in_each():
    found = weights(PAPER)
    assert list(found) == NAMES
    assert found["as-it-is"] == PAPER
    cautious = {"crosswalk_speeding": -3.0, "jaywalker_speeding": -3.0}
    assert found["caution-x10"] == replace(PAPER, driver_weights=PAPER.driver_weights | cautious)
    assert found["progress-x2"] == replace(PAPER, driver_weights=PAPER.driver_weights | {"crow_progress": 2.0})
    bonus = {"walked": 2.0, "arrival": 5.0, "collision": -25.0, "waiting_anywhere": 0.3}
    assert found["bonus-anywhere"] == replace(PAPER, pedestrian_weights=bonus)


@pytest.mark.long
def test_each_car_meets_always_go_and_its_own_people(tiny, tmp_path):
    base = replace(tiny, driver_weights=PAPER.driver_weights, pedestrian_weights=PAPER.pedestrian_weights)
    said = io.StringIO()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tournament, "evaluate_grid", partial(evaluate_grid, batch=PLAN.episodes))
        page = paper_weights(tmp_path / "out", PLAN, base=base, console=Console(file=said, width=200))
    document = json.loads((tmp_path / "out" / "paper-weights.json").read_text(encoding="utf-8"))
    assert document["street"]["sim"]["contact"] == "footprint"
    cells = [(cell["pedestrians"], cell["driver"], cell["training_seed"]) for cell in document["cells"]]
    assert cells == [(people, name, 3) for people in ("always-go", "learned") for name in NAMES]
    text = page.read_text(encoding="utf-8")
    assert "**Exploratory**: 1 training seed (3) and 2 of 6 updates." in text
    assert "nan" not in text
    assert "\n    5 trainings of 2 updates (" in said.getvalue()
