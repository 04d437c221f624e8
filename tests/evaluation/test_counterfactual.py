"""Collisions replayed with one thing changed: everything else stays, and known causes are found."""

from __future__ import annotations

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.evaluation import (
    ActionError,
    Counterfactuals,
    ReplayError,
    counterfactuals,
    evaluate,
    play,
    with_jaywalk_multiplier,
)
from jaxwalk.evaluation.hits import find_hits
from jaxwalk.evaluation.interventions import Brake, Since, TakeOver, Wait, on_the_crosswalk, with_changes
from jaxwalk.metrics import OUTCOMES
from jaxwalk.metrics.crossings import CROSSINGS
from jaxwalk.policies import AlwaysGo, Oracle, RouteFollower
from jaxwalk.policies.careful_human import CarefulHuman
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.observation import Observation, part

BATCH = 16
COLUMNS = [field.name for field in dataclasses.fields(Counterfactuals) if field.name != "collisions"]


class Car(RouteFollower):
    """Drives along its route without looking, or stands; from a step on, its throttle isn't a number."""

    throttle: jax.Array = eqx.field(kw_only=True)
    broken_from: jax.Array = eqx.field(default_factory=lambda: jnp.int32(10_000), kw_only=True)

    def init(self, agents, batch):
        return jnp.zeros(batch, jnp.int32)

    def act(self, key, memory, observation):
        action, _ = super().act(key, None, observation)
        return action.at[0].set(jnp.where(memory < self.broken_from, self.throttle, jnp.nan)), memory + 1


class People(AlwaysGo):
    """Go; lurkers stand at the kerb until a fast car is less than a second away, and then step out before it."""

    view: Observation = eqx.field(static=True, default=Observation("pedestrian", "kerb"))
    lurk: jax.Array = eqx.field(kw_only=True)

    def act(self, key, memory, observation):
        seen = {name: observation[part("pedestrian", "kerb", name)] for name in ("car_motion", "miss", "to_kerb")}
        fast = seen["car_motion"][0] * 8.33 > 7
        hit = (seen["miss"][0] * 10 < 1) & (seen["miss"][1] * 8 < 0.9)
        at_the_kerb = (seen["to_kerb"][0] > 0) & (seen["to_kerb"][0] < 0.25)
        return 1 - (self.lurk & at_the_kerb & ~(fast & hit)).astype(jnp.int32), memory


# the same kinds of policies everywhere: numbers in them compile nothing anew
BLIND, STANDING = Car(throttle=jnp.float32(1)), Car(throttle=jnp.float32(-1))
WALKERS, LURKERS = People(lurk=jnp.array(False)), People(lurk=jnp.array(True))
BLIND_ONE = {"driver": BLIND, "pedestrian": WALKERS}


@pytest.fixture(scope="module")
def often(street):
    """Everybody jaywalks at least as often as not."""
    return with_jaywalk_multiplier(street, 1.0)


@pytest.fixture(scope="module")
def hits(often, compiled_well):
    """The blind driver among always-go, 64 episodes."""
    return evaluate(often, BLIND_ONE, Drawn(often, 7, 64), batch=BATCH)


@pytest.fixture(scope="module")
def table(often, hits):
    return counterfactuals(often, BLIND_ONE, Drawn(often, 7), find_hits(hits), batch=BATCH)


@pytest.fixture(scope="module")
def batch(often):
    return Drawn(often, 7).take(np.arange(BATCH))


@pytest.fixture(scope="module")
def played(often, batch):
    return play(often, BLIND_ONE, *batch)


def frames_before(trajectory, last):
    """All numbers of the frames 0 .. last of each episode; NaN after it."""
    moving = [x for name, x in vars(trajectory).items() if name.startswith(("car_", "ped_"))]
    flat = np.concatenate([x.reshape(*x.shape[:2], -1) for x in moving], axis=2)
    kept = np.arange(len(flat))[:, None, None] <= np.asarray(last)[:, None]
    return np.where(kept, flat, np.nan)[: max(last) + 1]


def assert_same_until(last, one, other):
    """Two programs may round differently in the last bits, and do with the oldest JAX."""
    np.testing.assert_allclose(frames_before(one, last), frames_before(other, last), rtol=0, atol=1e-4)


def test_scenarios_are_chosen_by_number(street, batch):
    numbers = np.array([9, 3, 3, 15])
    chosen, keys = Drawn(street, 7).take(numbers)
    for one, every in zip(jax.tree.leaves(chosen), jax.tree.leaves(batch[0]), strict=True):
        np.testing.assert_array_equal(one, every[..., numbers])
    assert (keys == batch[1][numbers]).all()


def test_a_place_in_the_batch_changes_nothing_to_the_last_bit(often, played):
    numbers = np.arange(BATCH)[::-1]
    again = play(often, {"driver": BLIND, "pedestrian": WALKERS}, *Drawn(often, 7).take(numbers))
    for name, x in vars(played).items():
        if np.ndim(x) and name != "scenario":
            episode = 0 if len(x) == BATCH else 1
            np.testing.assert_array_equal(getattr(again, name), np.flip(x, axis=episode), err_msg=name)


def test_people_who_toss_coins_toss_the_same_ones_again(street, driver, undecided, rows):
    chosen = np.resize(np.flatnonzero(rows[OUTCOMES].collision), BATCH)
    again = play(street, {"driver": driver, "pedestrian": undecided}, *Drawn(street, 7).take(chosen))
    assert again.collision.all()
    np.testing.assert_array_equal(again.length, rows[OUTCOMES].steps[chosen])


def test_an_episode_can_be_stopped(often, batch, played):
    until = np.arange(20, 20 + 5 * BATCH, 5)
    stopped = play(often, {"driver": BLIND, "pedestrian": WALKERS}, *batch, until=until)
    np.testing.assert_array_equal(stopped.length, np.minimum(played.length, until))
    np.testing.assert_array_equal(stopped.collision, played.collision & (played.length <= until))
    np.testing.assert_array_equal(stopped.goal, played.goal & (played.length <= until))
    assert (stopped.length < played.length).any()


def test_who_is_to_wait_waits_and_nobody_else(often, batch, played):
    ped, begin = np.arange(BATCH) % 12, 10 + np.arange(BATCH)
    until = begin + 20
    waiting = Wait(WALKERS, jnp.asarray(ped), jnp.asarray(begin))
    changed = play(often, {"driver": BLIND, "pedestrian": waiting}, *batch, until=until)
    assert_same_until(begin, changed, played)
    for episode, last in enumerate(changed.length):
        going = changed.going[: last + 1, episode]
        assert going[: begin[episode] + 1, ped[episode]].all()
        assert not going[begin[episode] + 1 :, ped[episode]].any()
        assert np.delete(going, ped[episode], axis=1).all()


def test_the_car_brakes_and_steers_on(often, batch, played):
    begin = 20 + np.arange(BATCH)
    brakes = {"driver": Brake(BLIND, jnp.asarray(begin)), "pedestrian": WALKERS}
    changed = play(often, brakes, *batch, until=begin + 60)
    assert_same_until(begin, changed, played)
    under_way = changed.length > begin
    assert under_way.sum() > 10
    for episode in np.flatnonzero(under_way):
        assert (changed.car_acceleration[begin[episode] + 1 : changed.length[episode] + 1, episode] == -3).all()
    stood = changed.length == begin + 60
    assert (changed.car_speed[-1][stood] == 0).all()


def test_a_driver_takes_over(often, batch, played):
    begin = jnp.zeros(BATCH, jnp.int32)
    other = play(often, {"driver": STANDING, "pedestrian": WALKERS}, *batch)
    at_once = play(often, {"driver": TakeOver(STANDING, BLIND, begin), "pedestrian": WALKERS}, *batch)
    np.testing.assert_array_equal(at_once.length, played.length)
    assert_same_until(played.length, at_once, played)
    later = play(often, {"driver": TakeOver(STANDING, BLIND, begin + 30), "pedestrian": WALKERS}, *batch)
    before = np.minimum(other.length, 30)
    assert_same_until(before, later, other)
    assert (later.car_acceleration[31:40, later.length > 40] == 3).all()


def test_one_crossing_is_made_on_the_crosswalk(often, batch):
    scenarios, keys = batch
    before = play(often, {"driver": STANDING, "pedestrian": WALKERS}, scenarios, keys)
    jaywalks = (before.crossing == JAYWALK).any(axis=0)
    ped = jaywalks.argmax(axis=1)
    episode = np.flatnonzero(jaywalks.any(axis=1))
    when = (before.crossing[:, np.arange(BATCH), ped] == JAYWALK).argmax(axis=0)
    number = before.decisions[when, np.arange(BATCH), ped]
    after = play(often, {"driver": STANDING, "pedestrian": WALKERS}, on_the_crosswalk(scenarios, ped, number - 1), keys)
    assert len(episode) == BATCH
    for i in episode[after.length == 500]:
        mine = after.decisions[:, i, ped[i]] == number[i]
        assert set(after.crossing[mine, i, ped[i]]) <= {0, CROSSWALK}
        assert CROSSWALK in after.crossing[mine, i, ped[i]]
        others = np.arange(12) != ped[i]
        np.testing.assert_array_equal(
            after.ped_x[: before.length[i], i, others], before.ped_x[: before.length[i], i, others]
        )


def test_every_change_is_the_same_program(street):
    """Only its arrays differ, so nothing is compiled anew."""
    ped = np.arange(BATCH)
    changes = Since(), Since(wait=ped), Since(brake=ped), Since(oracle=ped, human=0 * ped)
    shapes = [jax.eval_shape(lambda x: x, with_changes(street, BLIND_ONE, ped, since)) for since in changes]
    assert all(eqx.tree_equal(one, shapes[0]) for one in shapes)


@pytest.mark.long
def test_each_change_begins_at_its_step(often, batch, played):
    """All four are around the policies, and one of them starts: each as it does alone, and none before."""
    ped, begin = np.arange(BATCH) % 12, 10 + np.arange(BATCH)

    def changed(since, until):
        return play(often, with_changes(often, BLIND_ONE, ped, since), *batch, until=until)

    unchanged = changed(Since(), played.length)
    np.testing.assert_array_equal(unchanged.length, played.length)
    assert_same_until(played.length, unchanged, played)
    oracle, human = (with_limits(other, often.config) for other in (Oracle(), CarefulHuman()))
    alone = {
        "wait": {"pedestrian": Wait(WALKERS, jnp.asarray(ped), jnp.asarray(begin))},
        "brake": {"driver": Brake(BLIND, jnp.asarray(begin))},
        "oracle": {"driver": TakeOver(BLIND, oracle, jnp.asarray(begin))},
        "human": {"driver": TakeOver(BLIND, human, jnp.asarray(begin))},
    }
    until = begin + 20
    for change, policies in alone.items():
        one, other = changed(Since(**{change: begin}), until), play(often, BLIND_ONE | policies, *batch, until=until)
        assert_same_until(np.minimum(begin, one.length), one, unchanged)
        np.testing.assert_array_equal(one.length, other.length)
        assert_same_until(one.length, one, other)
        assert (frames_before(one, one.length) != frames_before(unchanged, one.length)[: len(one.car_x)]).any()


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
