"""The page of a sweep: from results that are made by hand."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from jaxwalk.sweeps.drawn_trials import share_of
from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.sweep_page import sweep_page
from jaxwalk.sweeps.sweep_results import SweepResults, TrialResult
from jaxwalk.sweeps.trial_curves import TrialCurve, curve_of
from jaxwalk.sweeps.varied import ListedValues, ValueRange


@pytest.fixture
def results(study):
    """Three complete trials, of which the second is the best (least), and a pruned one."""
    plan = load_sweep(
        study(**{"[vary.driver_weights]": "[vary.train]\nminibatches = [1, 2, 4]\n[vary.driver_weights]"})
    )
    rows = [(0, 4.0, 1, -0.25), (1, 1.0, 2, -0.135), (2, 2.0, 4, -0.02), (3, None, 4, -0.1)]
    trials = tuple(
        TrialResult(
            number,
            "pruned" if value is None else "complete",
            value,
            {} if value is None else {"seed-0": value},
            {"train.minibatches": parts, "driver_weights.time": time},
            "after update 3 of <seed> 0" if value is None else None,
        )
        for number, value, parts, time in rows
    )
    curves = {0: TrialCurve((5, 10), (4.0, 2.0)), 3: TrialCurve((3,), (3.0,))}
    return SweepResults(plan, trials, {"driver_weights.time": 0.75, "train.minibatches": 0.25}, curves)


def lines(page, kind):
    return re.findall(rf'<polyline class="{kind}" points="([^"]*)"><title>([^<]*)</title>', page)


def test_the_page_says_what_is_best_and_that_it_is_optimistic(results):
    page = sweep_page(Path("runs/x"), results)
    assert "4 of 4 trials ended: 3 complete, 1 pruned" in page
    assert "The best of 3 complete trials is trial 1</b> with 1" in page and "this number is optimistic" in page
    assert re.findall(r"<code>runs/x/trials/(\d)/seed-0</code>", page) == ["1", "2", "0"]
    assert re.findall(r"<th scope=\"row\">([^<]*)</th><td>(\d+) %", page) == [
        ("driver_weights.time", "75"),
        ("train.minibatches", "25"),
    ]
    assert "after update 3 of &lt;seed&gt; 0" in page


def test_a_line_goes_through_its_values_and_ends_at_its_number(results):
    """Axes are 254 px high, from 16 to 270; the least number, the best, is at the bottom."""
    page = sweep_page(Path("runs/x"), results)
    (best,) = [points for points, said in lines(page, "best") if said.startswith("trial 1: 1;")]
    assert best == "70,143.0 220,143.0 370,270.0"
    others = [points for points, _ in lines(page, "other")]
    assert "70,270.0 220,270.0 370,16.0" in others and "70,16.0 220,16.0 370,185.3" in others
    assert [said for _, said in lines(page, "early")] == [
        "trial 3: pruned; train.minibatches 4, driver_weights.time -0.1"
    ]


def test_it_is_one_file_without_a_script(results):
    page = sweep_page(Path("runs/x"), results)
    assert "<script" not in page and not re.search(r"(src|href|url)\s*[=(]", page)


def test_without_a_complete_trial_there_is_a_page_too(results):
    few = replace(results, trials=results.trials[3:], importance={}, curves={})
    page = sweep_page(Path("runs/x"), few)
    assert "1 of 4 trials ended: 1 pruned" in page and "<svg" not in page and "Too few complete trials" in page


def test_a_curve_is_the_mean_over_seeds_and_updates(results):
    objective = results.plan.objective
    seeds = [
        [{"update": n, "episodes": 1, "reward/driver": float(n + 100 * seed)} for n in range(1, 121)] for seed in (0, 1)
    ]
    curve = curve_of(seeds, objective)
    assert curve.updates == tuple(range(2, 121, 2))
    assert curve.values[:2] == (51.5, 53.5)
    assert curve_of([[]], objective) is None


def test_updates_in_which_no_episode_ended_say_nothing_of_shares(results):
    """None of the first update, though the file has a number there; and none of one without the number."""
    objective = replace(results.plan.objective, metric="goal_rate")
    lines = [{"update": 1, "episodes": 0, "goal_rate": 0.0}, {"update": 2, "episodes": 3, "goal_rate": 0.5}]
    assert curve_of([[*lines, {"update": 3, "episodes": 2}]], objective) == TrialCurve((2,), (0.5,))


@pytest.mark.parametrize(
    ("varied", "value", "share"),
    [
        (ValueRange(1e-4, 1e-2, log=True), 1e-3, 0.5),
        (ValueRange(0.0, 4.0), 1.0, 0.25),
        (ListedValues(("a", "b", "c")), "b", 0.5),
    ],
    ids=["logarithm", "range", "list"],
)
def test_a_value_has_its_place_on_the_axis(varied, value, share):
    assert share_of(varied, value) == pytest.approx(share)


@pytest.fixture
def of_population(study):
    """Two generations of four members: the first one, the worst, is replaced by a copy of the fourth, now the best."""
    changes = {
        'sampler = "random"\ntrials = 4\n': 'sampler = "pbt"\n[pbt]\nmembers = 4\ngenerations = 2\n',
        "minimise": "maximise",
    }
    rows = [(1.0, None, -0.25), (2.0, None, -0.2), (3.0, None, -0.15), (4.0, None, -0.135)]
    rows += [(6.0, 3, -0.108), (2.5, 1, -0.2), (None, 2, -0.15)]
    trials = tuple(
        TrialResult(
            number, "failed" if value is None else "complete", value, {"seed-0": value or 0.0},
            {"driver_weights.time": time}, None, parent,
        )
        for number, (value, parent, time) in enumerate(rows)
    )  # fmt: skip
    curves = {3: TrialCurve((4, 5), (3.0, 4.0)), 4: TrialCurve((9, 10), (5.0, 6.0))}
    return SweepResults(load_sweep(study(**changes)), trials, {}, curves)


def test_the_page_of_a_population_shows_who_went_on_from_whom(of_population):
    """Members are 24 px apart, from 28; generations are at 242.5 and 587.5 px."""
    page = sweep_page(Path("runs/x"), of_population)
    assert "The best of 2 members in generation 1 is trial 4</b> with 6" in page
    assert "Which field mattered" not in page and "one of 4 members in one of 2 generations, 5 updates long" in page
    assert ("242.5,100.0 587.5,28.0", "trial 4: copied from trial 3") in lines(page, "best")
    assert ("242.5,52.0 587.5,52.0", "trial 5: its own, trial 1") in lines(page, "other")
    assert "<td>4</td><td>1</td><td>0</td><td>copied from trial 3</td><td>complete</td>" in page
    assert re.findall(r'<circle class="early" [^>]*><title>(trial \d+)', page) == ["trial 6", "trial 6"]


def test_the_page_of_a_population_shows_how_fields_moved(of_population):
    """-0.135 is at the middle of its axis, 143 px from the top, and -0.108 at 113.2: 254 px x 0.027 / 0.23 higher."""
    page = sweep_page(Path("runs/x"), of_population)
    assert "242.5,143.0 587.5,113.2" in [points for points, _ in lines(page, "best")]


def test_a_members_curve_begins_where_it_went_on_from(of_population):
    """The curves' axis goes from 3 to 6, updates from 0 to 10 over 690 px."""
    page = sweep_page(Path("runs/x"), of_population)
    assert "415.0,185.3 691.0,100.7 760.0,16.0" in [points for points, _ in lines(page, "best")]


def test_before_any_member_is_complete_there_is_a_page_too(of_population):
    page = sweep_page(Path("runs/x"), replace(of_population, trials=(), curves={}))
    assert "0 of 8 trials ended" in page and "<circle" not in page
