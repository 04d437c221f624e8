"""Collisions replayed with one thing changed: known causes are found."""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from evaluation.blind import BLIND, BLIND_ONE, LURKERS, STANDING, WALKERS, Car
from jaxwalk.evaluation import ActionError, Counterfactuals, ReplayError, counterfactuals, evaluate
from jaxwalk.evaluation.hits import find_hits
from jaxwalk.metrics import OUTCOMES
from jaxwalk.metrics.crossings import CROSSINGS
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK

BATCH = 16
COLUMNS = [field.name for field in dataclasses.fields(Counterfactuals) if field.name != "collisions"]


@pytest.fixture(scope="module")
def hits(often, compiled_well):
    """The blind driver among always-go, 64 episodes."""
    return evaluate(often, BLIND_ONE, Drawn(often, 7, 64), batch=BATCH)


@pytest.fixture(scope="module")
def table(often, hits):
    return counterfactuals(often, BLIND_ONE, Drawn(often, 7), find_hits(hits), batch=BATCH)


@pytest.mark.long
def test_every_collision_comes_back(table, hits):
    episodes = hits[OUTCOMES]
    assert table.collisions == len(table.scenario) == episodes.collision.sum() > 10
    np.testing.assert_array_equal(table.scenario, episodes.scenario[episodes.collision])
    np.testing.assert_array_equal(table.contact, episodes.contact[episodes.collision])
    assert {CROSSWALK, JAYWALK} <= set(table.contact)
    assert ((table.notice >= 0) & (table.notice * 10 <= episodes.steps[episodes.collision] + 1e-6)).all()


@pytest.mark.long
def test_nearly_all_could_be_avoided(table):
    assert table.planner_from_start.all()
    assert table.wait[table.wait_applies].mean() > 0.7  # the blind car may hit the next one
    assert table.crosswalk[table.crosswalk_applies].mean() > 0.7
    assert not table.crosswalk[~table.crosswalk_applies].any()
    assert table.brake[table.notice > 3].mean() > 0.9
    assert not table.brake[table.notice < 0.5].any()


@pytest.mark.long
def test_a_careful_human_takes_over_when_somebody_is_seen(table, hits):
    """Who is seen in frame 0 is seen from the start: then both replays are the same one."""
    steps = hits[OUTCOMES].steps[hits[OUTCOMES].collision]
    assert ((table.seen_for >= 0) & (table.seen_for * 10 <= steps + 1e-6)).all()
    at_once = np.isclose(table.seen_for * 10, steps)
    assert 0 < at_once.sum() < len(at_once)
    for driver in ("human", "planner"):
        when_seen, from_start = getattr(table, f"{driver}_when_seen"), getattr(table, f"{driver}_from_start")
        np.testing.assert_array_equal(when_seen[at_once], from_start[at_once])
    assert 0.2 < table.human_when_seen.mean() < 1
    assert {"human", "oracle"} <= set(table.judged)
    assert set(table.judged_from_start) == {"human", "oracle"}, "the oracle avoids all of them"


def assert_same_rows(a, b, order=slice(None)):
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name)[order], err_msg=name)


@pytest.mark.long
def test_how_many_are_replayed_changes_no_row(often, hits, table):
    told = []
    some = find_hits(hits).first(5)
    fewer = counterfactuals(often, BLIND_ONE, Drawn(often, 7), some, batch=BATCH, progress=lambda *n: told.append(n))
    assert (fewer.collisions, told) == (table.collisions, [(5, 5)])
    assert_same_rows(fewer, table, slice(5))
    assert not len(counterfactuals(often, BLIND_ONE, Drawn(often, 7), find_hits(hits).first(0), batch=BATCH).label)
    chosen = find_hits(hits).among(some.scenario[1:3].tolist())
    assert chosen.scenario.tolist() == some.scenario[1:3].tolist()
    with pytest.raises(ValueError, match="must be 0 or more, not -1"):
        find_hits(hits).first(-1)
    with pytest.raises(ValueError, match="batch must be at least 1"):
        counterfactuals(often, BLIND_ONE, Drawn(often, 7), some, batch=0)


@pytest.mark.long
def test_the_order_of_the_scenarios_changes_no_row(often, hits, table):
    order = np.random.default_rng(0).permutation(hits.episodes)
    columns = {name: x[order] for name, x in vars(hits[OUTCOMES]).items()}
    crossings = dataclasses.replace(hits[CROSSINGS], episode=np.argsort(order)[hits[CROSSINGS].episode])
    shuffled = hits.having(OUTCOMES, type(hits[OUTCOMES])(**columns)).having(CROSSINGS, crossings)
    found = counterfactuals(often, BLIND_ONE, Drawn(often, 7), find_hits(shuffled), batch=BATCH)
    assert_same_rows(table, found, np.argsort(found.scenario))


@pytest.mark.long
def test_another_evaluation_is_refused(often, hits):
    with pytest.raises(ReplayError, match="a replay without any change is at step"):
        counterfactuals(often, BLIND_ONE, Drawn(often, 8), find_hits(hits), batch=BATCH)


@pytest.mark.long
def test_a_driver_that_breaks_only_after_the_avoided_collision_is_said(often, hits, table):
    """The unchanged replay ends before; at the first changed one the collision doesn't end the episode."""
    one = find_hits(hits).some(np.flatnonzero(table.crosswalk)[:1])
    cast = {"driver": Car(throttle=jnp.float32(1), broken_from=jnp.int32(one.steps[0] + 1)), "pedestrian": WALKERS}
    message = rf"driver: its action is \[nan .*\(scenario {one.scenario[0]}, step {one.steps[0] + 1}\)"
    with pytest.raises(ActionError, match=message):
        counterfactuals(often, cast, Drawn(often, 7), one, batch=BATCH)


@pytest.mark.long
def test_who_steps_out_right_before_the_car_cannot_be_spared(often):
    rows = evaluate(often, {"driver": BLIND, "pedestrian": LURKERS}, Drawn(often, 7, 32), batch=BATCH)
    cast = {"driver": BLIND, "pedestrian": LURKERS}
    found = counterfactuals(often, cast, Drawn(often, 7), find_hits(rows).first(BATCH), batch=BATCH)
    assert len(found.label) > 5 and not (found.brake | found.planner).any()
    assert found.wait.mean() > 0.7
    assert set(found.label) <= {"pedestrian", "unavoidable"}
    assert found.human_when_seen.mean() < 0.5, "it doesn't brake for who stands at the kerb"


@pytest.mark.long
def test_a_standing_car_cannot_brake(often):
    rows = evaluate(often, {"driver": STANDING, "pedestrian": WALKERS}, Drawn(often, 7, 128), batch=BATCH)
    cast = {"driver": STANDING, "pedestrian": WALKERS}
    found = counterfactuals(often, cast, Drawn(often, 7), find_hits(rows).first(BATCH), batch=BATCH)
    assert len(found.label) > 3 and not (found.moving | found.brake).any()
    assert found.wait.all() and found.planner.any()  # it drives away
    assert set(found.label) <= {"either", "pedestrian"}
